//! Random cases of each kind of contact with sheets, from the case file on. In every one of them no particle crosses a
//! sheet, contact dissipates energy and returns none, momentum changes by the external impulse, the ledger closes, and
//! there is no notice about the balances.

use lateen::case::{Case, Source};
use lateen::simulation::{Snapshot, Solver};
use std::f64::consts::PI;

/// Part of the work done that contact, friction and walls may return.
const GIVEN: f64 = 1e-3;

/// Part of the largest momentum, and of the largest energy, that may be unexplained.
const ROUND_OFF: f64 = 1e-9;

/// Steps between two checks of the ledger.
const EVERY: usize = 8;

/// Numbers from a seed (Knuth's linear congruential generator).
struct Draw(u64);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// From [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    fn of<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize].clone()
    }
}

/// A length that four decimals hold [m], so that ends of a grid are whole numbers of cells apart.
fn rounded(x: f64) -> f64 {
    (x * 1e4 + 0.5).floor() / 1e4
}

/// A number as a case file has it.
fn number(x: f64) -> String {
    format!("{x:.6}")
}

fn pair([x, y]: [f64; 2]) -> String {
    format!("[{x:.6}, {y:.6}]")
}

/// A square grid around the origin that begins anywhere in a cell.
fn grid(draw: &mut Draw, cell: f64, size: f64, top: f64, walls: &str) -> String {
    let lower = [-size - rounded(draw.within(0.0, cell)), -size - rounded(draw.within(0.0, cell))];
    let upper: [f64; 2] = std::array::from_fn(|a| lower[a] + ((([size, top][a] - lower[a]) / cell).ceil()) * cell);
    format!("[grid]\ncell = {cell:.4}\nlower = {}\nupper = {}\n{walls}", pair(lower), pair(upper))
}

fn chain(points: &[[f64; 2]], closed: bool) -> String {
    let points: Vec<String> = points.iter().copied().map(pair).collect();
    format!("{{ shape = \"chain\", points = [{}], divisions = [1], closed = {closed} }}", points.join(", "))
}

const FALL: &str = "[mpm]\ngravity = [0, -9.81]\n";
const BOX: &str = "walls = { left = \"slip\", right = \"slip\", bottom = \"separate\" }\n";

/// A closed chain of `n` elements.
fn ellipse([a, b]: [f64; 2], angle: f64, n: u32) -> String {
    let corner = |k: u32| {
        let t = 2.0 * PI * f64::from(k) / f64::from(n);
        let (x, y) = (a * t.cos(), b * t.sin());
        [x * angle.cos() - y * angle.sin(), x * angle.sin() + y * angle.cos()]
    };
    chain(&(0..n).map(corner).collect::<Vec<_>>(), true)
}

/// A flat closed loop full of gas, which flies and breathes, in vacuum or in an atmosphere: contact at nodes.
fn gas(draw: &mut Draw) -> String {
    let cell = rounded(draw.within(0.07, 0.1));
    let a = draw.within(0.4, 0.5);
    let b = a * draw.within(0.3, 0.7);
    let angle = draw.within(0.0, PI);
    let geometry = ellipse([a, b], angle, (PI * (a + b) / (cell * draw.within(0.6, 1.1))) as u32);
    let pressure = draw.within(1.0, 5.0);
    let ambient = draw.of(&[String::new(), format!("ambient = {:.6}\n", 0.5 * pressure)]);
    let velocity = pair([draw.within(-0.1, 0.1), draw.within(-0.1, 0.1)]);
    let thickness = draw.within(0.01, 0.04);
    let (young, density) = (10.0_f64.powf(draw.within(3.0, 4.3)), draw.within(0.05, 0.3) / thickness);
    let (wrinkling, viscosity) = (draw.of(&[true, false]), draw.of(&["0", "0.02"]));
    let (grid, [long, short]) = (grid(draw, cell, 2.0, 2.0, ""), [0.95 * a, 0.95 * b].map(number));
    format!(
        r#"name = "gas"
dimension = 2
units = "none"
[time]
end = 5
{grid}[[body]]
name = "gas"
region = {{ shape = "rotated", angle = {angle:.6}, of = {{ shape = "ellipsoid", center = [0, 0], semi-axes = [{long}, {short}] }} }}
particles-per-cell = 3
pressure = {pressure:.6}
{ambient}velocity = {velocity}
material = {{ law = "fluid", density = 1, viscosity = {viscosity}, eos = {{ kind = "ideal-gas", gamma = 1.4 }} }}
[[membrane]]
name = "sheet"
geometry = {geometry}
thickness = {thickness:.6}
velocity = {velocity}
material = {{ law = "elastic", density = {density:.6}, young = {young:.6}, poisson = 0.3, wrinkling = {wrinkling} }}
"#
    )
}

/// A slack sheet that hangs by its ends.
fn hung(draw: &mut Draw, cell: f64) -> String {
    let (span, depth) = (draw.within(0.7, 1.0), draw.within(0.15, 0.4));
    let length = span * (1.0 + 2.0 * (PI * depth / (2.0 * span)).powi(2)).sqrt();
    let n = (length / (cell * draw.within(0.6, 1.1))) as u32;
    let place = |k: u32| f64::from(k) / f64::from(n) - 0.5;
    let points: Vec<_> = (0..=n).map(|k| [span * place(k), -depth * (PI * place(k)).cos()]).collect();
    let (thickness, young) = (10.0_f64.powf(draw.within(-4.0, -3.3)), 10.0_f64.powf(draw.within(7.5, 8.5)));
    format!(
        r#"[[membrane]]
name = "sheet"
geometry = {}
thickness = {thickness:.6}
material = {{ law = "elastic", density = 1000, young = {young:.6}, poisson = 0.3, wrinkling = true }}
supports = [{{ on = "left", velocity = [0, 0] }}, {{ on = "right", velocity = [0, 0] }}]
"#,
        chain(&points, false)
    )
}

/// Water falls into a slack sheet: contact at particles.
fn liquid(draw: &mut Draw) -> String {
    let cell = rounded(draw.within(0.02, 0.03));
    let (w, h) = (draw.within(0.2, 0.3), draw.within(0.1, 0.2));
    let (x, y) = (draw.within(-0.05, 0.05), draw.within(0.03, 0.15));
    let (velocity, sound) = (pair([draw.within(-0.5, 0.5), draw.within(-2.0, 0.0)]), draw.within(30.0, 60.0));
    let (lower, upper) = (pair([x - 0.5 * w, y]), pair([x + 0.5 * w, y + h]));
    let grid = grid(draw, cell, 1.0, 2.0, BOX);
    let sheet = hung(draw, cell);
    format!(
        r#"name = "liquid"
dimension = 2
[time]
end = 0.35
{grid}{FALL}[[body]]
name = "water"
region = {{ shape = "box", lower = {lower}, upper = {upper} }}
particles-per-cell = 2
velocity = {velocity}
material = {{ law = "fluid", density = 1000, viscosity = 0.001, eos = {{ kind = "tait", sound-speed = {sound:.6} }} }}
{sheet}"#
    )
}

/// A ball or a block falls into a slack sheet: contact at points on the skin of the solid.
fn solid(draw: &mut Draw) -> String {
    let cell = rounded(draw.within(0.02, 0.03));
    let (r, x) = (draw.within(0.08, 0.12), draw.within(-0.05, 0.05));
    let y = 1.25 * r + draw.within(0.02, 0.1);
    let angle = draw.within(0.0, 1.5);
    let (center, lower, upper) = (pair([x, y]), pair([x - r, y - 0.7 * r]), pair([x + r, y + 0.7 * r]));
    let region = draw.of(&[
        format!("{{ shape = \"sphere\", center = {center}, radius = {r:.6} }}"),
        format!(
            "{{ shape = \"rotated\", angle = {angle:.6}, about = {center}, of = {{ shape = \"box\", lower = {lower}, upper = {upper} }} }}"
        ),
    ]);
    let velocity = pair([draw.within(-0.5, 0.5), draw.within(-2.0, 0.0)]);
    let (density, young) = (draw.within(300.0, 1500.0), 10.0_f64.powf(draw.within(5.0, 6.5)));
    let friction = draw.of(&["0", "0.3"]);
    let grid = grid(draw, cell, 1.0, 2.0, BOX);
    let sheet = hung(draw, cell);
    format!(
        r#"name = "solid"
dimension = 2
[time]
end = 0.5
{grid}{FALL}friction = {friction}
[[body]]
name = "body"
region = {region}
particles-per-cell = 2
velocity = {velocity}
material = {{ law = "neo-hookean", density = {density:.6}, young = {young:.6}, poisson = 0.3 }}
{sheet}"#
    )
}

/// A strip falls on an obstacle and past it on a floor.
fn wall(draw: &mut Draw) -> String {
    let (length, tilt) = (draw.within(0.5, 0.8), draw.within(-0.3, 0.3));
    let (x, y) = (draw.within(-0.1, 0.1), draw.within(0.35, 0.45));
    let n = (length / draw.within(0.02, 0.04)) as u32;
    let velocity = pair([draw.within(-0.5, 0.5), draw.within(-2.0, 0.0)]);
    let (thickness, young) = (10.0_f64.powf(draw.within(-3.3, -2.7)), 10.0_f64.powf(draw.within(6.0, 7.5)));
    let ([a, b], r) = ([draw.within(-0.1, 0.1), draw.within(0.0, 0.05)], draw.within(0.08, 0.12));
    let region = draw.of(&[
        format!("{{ shape = \"sphere\", center = {}, radius = {r:.6} }}", pair([a, b])),
        format!("{{ shape = \"box\", lower = [{:.6}, -0.5], upper = {} }}", a - r, pair([a + r, b + 0.5 * r])),
    ]);
    let kind = draw.of(&["\"separate\"", "\"friction\"\ncoefficient = 0.25", "\"fixed\""]);
    let floor = draw.of(&["\"separate\"", "{ kind = \"friction\", coefficient = 0.3 }", "\"fixed\""]);
    let place = |k: u32| length * (f64::from(k) / f64::from(n) - 0.5);
    let points: Vec<_> = (0..=n).map(|k| [x + place(k) * tilt.cos(), y + place(k) * tilt.sin()]).collect();
    let left = -1.5 - rounded(draw.within(0.0, 0.05));
    let (lower, upper, geometry) = (pair([left, 0.0]), pair([left + 3.0, 1.5]), chain(&points, false));
    format!(
        r#"name = "wall"
dimension = 2
[time]
end = 0.4
[grid]
cell = 0.05
lower = {lower}
upper = {upper}
walls = {{ left = "slip", right = "slip", bottom = {floor} }}
{FALL}[[membrane]]
name = "sheet"
geometry = {geometry}
thickness = {thickness:.6}
velocity = {velocity}
material = {{ law = "elastic", density = 1000, young = {young:.6}, poisson = 0.3, wrinkling = true }}
[[obstacle]]
name = "thing"
region = {region}
kind = {kind}
"#
    )
}

/// The ledger at one time.
struct LedgerTerms {
    terms: Vec<(String, f64)>,
    closure: f64,
}

impl LedgerTerms {
    fn of(snapshot: &Snapshot<'_>) -> Self {
        let terms: Vec<_> = snapshot.ledger.terms.iter().map(|term| (term.name.to_string(), term.value)).collect();
        let mut ledger = Self { terms, closure: 0.0 };
        ledger.closure = snapshot.ledger.closure(ledger.get("stored energy at the start"));
        ledger
    }

    /// A term, 0 where there is none.
    fn get(&self, name: &str) -> f64 {
        self.terms.iter().find(|(own, _)| own == name).map_or(0.0, |(_, value)| *value)
    }

    /// The sum of the terms of all parts.
    fn all(&self, name: &str) -> f64 {
        self.terms.iter().filter(|(own, _)| own.starts_with(name)).map(|(_, value)| *value).sum()
    }
}

/// The condition on the energy that contact has dissipated.
#[derive(Clone, Copy)]
enum Dissipation {
    /// It never falls: at particles, and of sheets with walls and obstacles.
    NeverFalls,
    /// It is never below zero: at nodes.
    NeverNegative,
}

/// Conditions that are checked throughout a run.
struct Invariants {
    seed: u64,
    dissipation: Dissipation,
    start: LedgerTerms,
    /// The largest kinetic energy, work of gravity or of the bodies' stresses so far [J], and the largest momentum
    /// [N s].
    work: f64,
    momentum: f64,
    /// The most that each kind of contact has taken so far [J].
    taken: [f64; 3],
}

const TAKEN: [&str; 3] = ["contact dissipation", "friction dissipation", "wall dissipation"];
const MOMENTA: [[&str; 2]; 2] = [["momentum x", "external impulse x"], ["momentum y", "external impulse y"]];

impl Invariants {
    fn check(&mut self, ledger: &LedgerTerms, t: f64) {
        let stored = ledger.all("internal energy") - self.start.all("internal energy");
        let works = [ledger.all("kinetic energy"), ledger.get("work of gravity").abs(), stored.abs()];
        self.work = works.into_iter().fold(self.work, f64::max);
        let seed = self.seed;
        for (name, taken) in TAKEN.iter().zip(&mut self.taken) {
            let now = ledger.get(name);
            let least = match self.dissipation {
                Dissipation::NeverFalls => *taken,
                Dissipation::NeverNegative => 0.0,
            };
            let (low, work) = (least - GIVEN * self.work, self.work);
            assert!(now >= low, "seed {seed}, t = {t}: {name} {now} J after {taken} J, work {work} J");
            *taken = taken.max(now);
        }
        for [momentum, impulse] in MOMENTA {
            let (p, j) = (ledger.get(momentum), ledger.get(impulse));
            self.momentum = self.momentum.max(p.abs()).max(j.abs());
            let off = p - self.start.get(momentum) - j;
            assert!(off.abs() <= ROUND_OFF * self.momentum, "seed {seed}, t = {t}: {momentum} off by {off} N s");
        }
        let scale = ledger.all("internal energy").abs().max(self.work);
        assert!(ledger.closure.abs() <= ROUND_OFF * scale, "seed {seed}, t = {t}: closure {} J", ledger.closure);
    }
}

/// Runs the case of a seed and checks its conditions.
fn run_case(make: fn(&mut Draw) -> String, dissipation: Dissipation, seed: u64) {
    let text = make(&mut Draw::new(seed));
    let case =
        Case::read(Source::new("case.toml", "", text), &[]).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    let (end, mut solver) = (case.file.time.end, case.build().unwrap_or_else(|error| panic!("seed {seed}: {error}")));
    let start = LedgerTerms::of(&solver.snapshot());
    let mut invariants = Invariants { seed, dissipation, start, work: 0.0, momentum: 0.0, taken: [0.0; 3] };
    let (mut t, mut steps) = (0.0, 0);
    while t < end * (1.0 - 1e-12) {
        let dt = solver.stable_dt().min(end - t).min(end / 100.0);
        solver.step(t, dt).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        (t, steps) = (t + dt, steps + 1);
        if steps % EVERY == 0 || t >= end {
            invariants.check(&LedgerTerms::of(&solver.snapshot()), t);
        }
    }
    conclude(solver, &invariants);
}

/// At the end nothing has crossed, contact has happened, and no notice says that something gave energy.
fn conclude(mut solver: Box<dyn Solver>, invariants: &Invariants) {
    let seed = invariants.seed;
    let crossed = |(name, count): &(String, u64)| name.starts_with("crossed") && *count > 0;
    let counts = solver.snapshot().counts.to_vec();
    assert!(!counts.iter().any(crossed), "seed {seed}: {counts:?}");
    assert!(
        invariants.taken.iter().sum::<f64>() > 1e-6 * invariants.work,
        "seed {seed}: nothing has met: {:?}",
        invariants.taken
    );
    let said = solver.notices();
    assert!(!said.iter().any(|text| text.contains("below zero") || text.contains("crossed")), "seed {seed}: {said:?}");
}

#[test]
fn contact_of_gas_with_sheets_at_nodes_keeps_the_balances_and_sides() {
    (1..=8).for_each(|seed| run_case(gas, Dissipation::NeverNegative, seed));
}

#[test]
fn contact_of_liquid_with_sheets_keeps_the_balances_and_sides() {
    (1..=8).for_each(|seed| run_case(liquid, Dissipation::NeverFalls, seed));
}

#[test]
fn contact_of_solids_with_sheets_keeps_the_balances_and_sides() {
    (1..=8).for_each(|seed| run_case(solid, Dissipation::NeverFalls, seed));
}

#[test]
fn contact_of_sheets_with_obstacles_and_walls_keeps_the_balances() {
    (1..=8).for_each(|seed| run_case(wall, Dissipation::NeverFalls, seed));
}
