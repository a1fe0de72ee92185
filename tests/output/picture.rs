//! Pictures of scenes whose look is known. They stay in the target directory (`tmp/pictures`) to be looked at: most of
//! a picture has no other reference than the eye.

use lateen::output::image::Image;
use lateen::output::picture::{BoxCorners, PictureObstacle};
use lateen::output::{Picture, PictureSpec};
use lateen::simulation::{Elements, Field, Monitor, PointSet, Snapshot, SurfaceSet};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Particles and a membrane, with what they show.
#[derive(Default)]
struct Model {
    dimension: usize,
    particles: Vec<[f64; 3]>,
    volume: Vec<f64>,
    speed: Vec<f64>,
    nodes: Vec<[f64; 3]>,
    elements: Vec<Vec<u32>>,
    node_speed: Vec<f64>,
}

impl Model {
    fn snapshot(&self, time: f64) -> Snapshot<'_> {
        let id: Vec<u32> = (0..self.particles.len() as u32).collect();
        let points = PointSet {
            name: "water",
            position: Cow::Borrowed(&self.particles),
            id: Cow::Owned(id),
            fields: vec![Field::scalar("volume", "m^3", &self.volume), Field::scalar("speed", "m/s", &self.speed)],
            filled: None,
        };
        let surface = SurfaceSet {
            name: "sheet",
            position: Cow::Borrowed(&self.nodes),
            reference: Cow::Borrowed(&self.nodes),
            elements: self.elements.iter().map(Vec::as_slice).collect(),
            kind: Elements::Sheet,
            node_fields: vec![Field::scalar("speed", "m/s", &self.node_speed)],
            element_fields: vec![],
        };
        Snapshot {
            time,
            dimension: self.dimension,
            points: vec![points],
            surfaces: vec![surface],
            ..Snapshot::default()
        }
    }

    /// A ball of particles over a square sheet with a dent of depth `dent` [m].
    fn drop(height: f64, squash: f64, dent: f64) -> Self {
        let mut model = Self { dimension: 3, ..Self::default() };
        let (h, radius) = (0.5e-3, 4.5e-3);
        let range = -9..9;
        for (i, j, k) in range.clone().flat_map(|i| (-9..9).flat_map(move |j| (-9..9).map(move |k| (i, j, k)))) {
            let x = [i, j, k].map(|n: i32| (f64::from(n) + 0.5) * h);
            let r = x.iter().map(|c| c * c).sum::<f64>().sqrt();
            if r < radius {
                let spread = 1.0 / squash.sqrt();
                let place = [x[0] * spread, x[1] * spread, height + x[2] * squash];
                model.particles.push(place);
                model.volume.push(h * h * h);
                model.speed.push(2.0 + 8.0 * (place[2] - height + radius) / (2.0 * radius));
            }
        }
        let n = 50;
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let [x, y] = [i, j].map(|k| (f64::from(k) - 25.0) * 1e-3);
            let r2 = (x * x + y * y) / 8e-3_f64.powi(2);
            model.nodes.push([x, y, -dent * (-r2).exp()]);
            model.node_speed.push(6.0 * (-r2).exp());
        }
        let node = |i: u32, j: u32| i * 51 + j;
        model.elements = (0..50)
            .flat_map(|i| (0..50).map(move |j| vec![node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]))
            .collect();
        model
    }

    /// A block of water in a tank, with a flexible wall.
    fn dam() -> Self {
        let mut model = Self { dimension: 2, ..Self::default() };
        for (i, j) in (0..100).flat_map(|i| (0..100).map(move |j| (i, j))) {
            let [x, y] = [i, j].map(|n| (f64::from(n) + 0.5) * 0.01);
            let top = 0.9 - 0.5 * x * x;
            if y < top {
                model.particles.push([x, y, 0.0]);
                model.volume.push(1e-4);
                model.speed.push(9810.0 * (top - y));
            }
        }
        model.nodes = (0..=20).map(|i| f64::from(i) * 0.02).map(|s| [1.3 + 0.4 * s * s, s, 0.0]).collect();
        model.elements = (0..20).map(|i| vec![i, i + 1]).collect();
        model.node_speed = vec![0.0; 21];
        model
    }
}

/// Half a cylinder on the floor, which has rolled 0.2 m at the time of the pictures.
struct Bump;

impl PictureObstacle for Bump {
    fn distance(&self, x: [f64; 3]) -> f64 {
        (x[0] - 1.5).hypot(x[1]) - 0.15
    }

    fn displacement(&self, t: f64) -> [f64; 3] {
        [0.2 * t / 2.4e-4, 0.0, 0.0]
    }
}

const BOX: BoxCorners = [[-0.027, -0.027, -0.012], [0.027, 0.027, 0.014]];
const TANK: BoxCorners = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0]];

fn picture(model: &Model, domain: BoxCorners, keys: &str) -> Picture {
    let spec: PictureSpec = toml::from_str(&format!("name = \"p\"\n{keys}")).unwrap();
    let directory = Path::new("unused");
    Picture::new(spec, "picture[0]", &model.snapshot(0.0), domain, directory, 2e-4).unwrap()
}

/// Renders, and keeps the picture for a look.
fn render(model: &Model, name: &str, picture: &Picture) -> Image {
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    std::fs::create_dir_all(&directory).unwrap();
    let image = picture.render(&model.snapshot(2.4e-4)).unwrap();
    image.write_png(&directory.join(format!("{name}.png"))).unwrap();
    image
}

fn pixel(image: &Image, x: f64, y: f64) -> [u8; 3] {
    let at = (y * image.height as f64) as usize * image.width + (x * image.width as f64) as usize;
    std::array::from_fn(|c| image.pixels[3 * at + c])
}

/// The fast top of a drop over a sheet at rest, in published colours (viridis begins with 68, 1, 84); the same in plain
/// colours, and cut open, when the near half of the sheet is gone.
#[test]
fn pictures_show_bodies_and_sheets_in_the_colours_of_their_field() {
    let model = Model::drop(4.5e-3, 0.8, 3e-3);
    let image = render(&model, "drop", &picture(&model, BOX, "field = \"speed\"\nview = [1, -2, 0.9]"));
    assert_eq!((image.width, image.height), (1280, 960));
    assert_eq!(pixel(&image, 0.98, 0.98), [255; 3], "nothing is white");
    let [rest, top] = [pixel(&image, 0.3, 0.6), pixel(&image, 0.5, 0.4)];
    assert!(rest.iter().zip([68, 1, 84]).all(|(&shown, viridis)| shown.abs_diff(viridis) < 8), "{rest:?}");
    assert!(top[1] > 150 && top[2] < 110, "8 m/s of 10 is yellow-green: {top:?}");
    let plain = picture(&model, BOX, "frame = \"start\"\nview = [1, -2, 0.9]\nsize = [640, 480]");
    let plain = render(&model, "drop-plain", &plain);
    let [drop, sheet] = [pixel(&plain, 0.5, 0.45), pixel(&plain, 0.3, 0.6)];
    assert!(drop[2] > drop[0] && sheet[0] > sheet[2], "a blue drop on an orange sheet: {drop:?} {sheet:?}");
    let cut = "field = \"speed\"\nplain = [\"sheet\"]\nopacity = 0.5\ncut = { normal = [0, -1, 0] }\nmap = \"inferno\"\n\
               range = [0, 10]\nsize = [640, 480]\nframe = { lower = [-0.012, -0.012, -0.006], upper = [0.012, 0.012, 0.01] }";
    let cut = render(&model, "drop-cut", &picture(&model, BOX, cut));
    assert_eq!(pixel(&cut, 0.3, 0.6), [255; 3], "the near half of the sheet is cut off");
    let [middle, top] = [pixel(&cut, 0.5, 0.5), pixel(&cut, 0.5, 0.4)];
    assert!(top[0] > middle[0] && top[2] < middle[2], "inferno goes from violet to yellow: {middle:?} {top:?}");
}

#[test]
fn a_dam_in_two_dimensions_has_the_colours_of_the_bar() {
    let model = Model::dam();
    let keys =
        "of = [\"water\", \"sheet\"]\nfield = \"speed\"\nplain = [\"sheet\"]\nrange = [0, 10000]\nsize = [640, 480]";
    let picture = picture(&model, TANK, keys).with_obstacle(Box::new(Bump));
    let image = render(&model, "dam", &picture);
    assert_eq!(pixel(&image, 0.8, 0.3), [255; 3], "nothing is white");
    assert_eq!(pixel(&image, 0.746, 0.75), [0xb9, 0xbc, 0xc2], "the obstacle is where it has moved to");
    let deep = pixel(&image, 0.05, 0.66);
    assert!(
        deep[0] > 30 && deep[0] < 90 && deep[1] > 165 && deep[2] < 140,
        "6.5 kPa of 10 is green in viridis: {deep:?}"
    );
}

/// Values from −2 to 8: zero is grey, and what is as far below it as another above has as much colour.
#[test]
fn the_middle_of_blue_and_red_is_zero() {
    let mut model = Model::dam();
    model.speed = model.particles.iter().map(|x| 10.0 * x[0] - 2.0).collect();
    let keys = "of = [\"water\"]\nfield = \"speed\"\nmap = \"blue-red\"\nframe = \"start\"";
    let image = render(&model, "dam-signs", &picture(&model, TANK, keys));
    let across = (0..1000).map(|i| pixel(&image, f64::from(i) / 1000.0, 0.6));
    let row: Vec<[u8; 3]> = across.filter(|pixel| *pixel != [255; 3]).collect();
    let grey = row.iter().position(|pixel| pixel.iter().all(|c| c.abs_diff(0xdd) < 4)).unwrap();
    assert!((0.15..0.25).contains(&(grey as f64 / row.len() as f64)), "{grey} of {}", row.len());
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let model = Model::drop(4.5e-3, 0.8, 3e-3);
    let picture = picture(&model, BOX, "field = \"speed\"\nsize = [320, 240]\nopacity = 0.5");
    let render = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture.render(&model.snapshot(0.0)).unwrap())
    };
    assert!(render(1) == render(3));
}

#[test]
fn values_that_are_not_finite_never_panic_the_renderer() {
    let mut model = Model::drop(4.5e-3, 1.0, 0.0);
    model.particles[0] = [f64::NAN, 0.0, f64::INFINITY];
    model.speed[1] = f64::NAN;
    model.volume[2] = f64::INFINITY;
    model.nodes[7] = [f64::NEG_INFINITY; 3];
    let image = picture(&model, BOX, "field = \"speed\"\nsize = [320, 240]").render(&model.snapshot(0.0)).unwrap();
    assert_eq!(image.pixels.len(), 3 * 320 * 240);
}

#[test]
fn unknown_names_and_impossible_values_are_errors_at_their_key() {
    let model = Model::drop(4.5e-3, 1.0, 0.0);
    let error = |keys: &str| {
        let spec: PictureSpec = toml::from_str(&format!("name = \"p\"\n{keys}")).unwrap();
        let initial = model.snapshot(0.0);
        let picture = Picture::new(spec, "picture[0]", &initial, BOX, Path::new("unused"), 1.0);
        picture.err().unwrap()
    };
    assert!(error("of = [\"shet\"]").help.unwrap().contains("did you mean `sheet`"));
    assert_eq!(error("field = \"sped\"").key, "picture[0].field");
    assert_eq!(error("range = [1, 1]").key, "picture[0].range");
    assert_eq!(error("frame = { lower = [1.0, 0, 0], upper = [-1.0, 1, 1] }").key, "picture[0].frame");
    assert_eq!(error("size = [1, 100000]").key, "picture[0].size");
    assert_eq!(error("opacity = 0").key, "picture[0].opacity");
    assert_eq!(error("view = [0, 0, 0]").key, "picture[0].view");
    assert_eq!(error("cut = { normal = [0, 0, 0] }").key, "picture[0].cut.normal");
    assert_eq!(error("view = [0, 1, 0]\nup = [0, -2, 0]").key, "picture[0].up");
}

#[test]
fn a_resumed_run_continues_the_numbers_of_its_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let model = Model::dam();
    let run = |resume: Option<f64>, times: &[f64]| {
        let spec: PictureSpec = toml::from_str("name = \"dam\"\nsize = [64, 64]").unwrap();
        let initial = model.snapshot(0.0);
        let mut picture = Picture::new(spec, "picture[0]", &initial, TANK, dir.path(), 0.1).unwrap();
        if let Some(time) = resume {
            picture.resume(time).unwrap();
        }
        times.iter().for_each(|&time| picture.sample(&model.snapshot(time), time).unwrap());
        std::fs::read_to_string(dir.path().join("dam.csv")).unwrap()
    };
    let whole = run(None, &[0.0, 0.1, 0.2]);
    assert_eq!(run(Some(0.1), &[0.1, 0.2]), whole);
    assert_eq!(std::fs::read_dir(dir.path().join("dam")).unwrap().count(), 3);
}
