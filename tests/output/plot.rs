//! Plots of histories and of the energy balance. The files stay in the target directory (`tmp/plots`)
//! to be looked at.

use lateen::output::history::HistoryTable;
use lateen::output::image::Image;
use lateen::output::plot::{
    CurveShape, Data, HorizontalLine, PhaseReference, PlotAxis, PlotSeries, PlotSpec, ReferenceCurve, plot_run,
    to_image, to_svg,
};
use std::fs;
use std::path::PathBuf;

fn directory(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("plots").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn damped(t: f64) -> f64 {
    -4e-3 * (1.0 - (-t / 4e-4).exp() * (t / 5e-5).cos())
}

#[test]
fn every_history_gets_a_plot_per_unit_and_per_column_with_references() {
    let dir = directory("histories");
    let mut probe = String::from("time [s],x [m],z [m],vz [m/s]\n");
    let mut balance = String::from(
        "time [s],mass [kg],kinetic energy: water [J],strain energy: sheet [J],contact [J],never [J],\
         stored energy [J],gained energy [J],lost energy [J],closure [J]\n",
    );
    for i in 0..=600 {
        let t = 2e-6 * f64::from(i);
        probe.push_str(&format!("{t:?},{:?},{:?},{:?}\n", 1e-4 * (t / 1e-4).sin(), damped(t), -10.0 + 9e3 * t));
        let (kinetic, loss) = (0.019 * (-t / 5e-4).exp(), 0.002 * (t / 1.2e-3));
        let strain = 0.019 - kinetic - loss;
        let closure = 1e-17 * (i % 7) as f64;
        let stored = kinetic + strain;
        balance.push_str(&format!("{t:?},0.001,{kinetic:?},{strain:?},{loss:?},0,{stored:?},0,{loss:?},{closure:?}\n"));
    }
    let histories = dir.join("history");
    fs::create_dir_all(&histories).unwrap();
    fs::write(histories.join("centre.csv"), probe).unwrap();
    fs::write(histories.join("balance.csv"), balance).unwrap();
    let times = (0..=24).map(|i| 5e-5 * f64::from(i));
    let points: Vec<[f64; 2]> = times.clone().map(|t| [t, 1.03 * damped(t)]).collect();
    let band: Vec<[f64; 3]> =
        (0..=120).map(|i| 1e-5 * f64::from(i)).map(|t| [t, damped(t) - 3e-4, damped(t) + 3e-4]).collect();
    let reference = |label: &str, shape| ReferenceCurve {
        history: "centre".into(),
        plus: None,
        column: "z".into(),
        label: label.into(),
        shape,
        phase: None,
    };
    let references = [
        reference("Somebody et al. (2014), digitised", CurveShape::Points(points)),
        reference("five independent programs", CurveShape::Band(band)),
    ];
    plot_run(&histories, &dir, &references).unwrap();

    for stem in ["centre-x", "centre-z", "centre-vz", "balance", "closure"] {
        assert!(dir.join(format!("{stem}.svg")).exists() && dir.join(format!("{stem}.png")).exists(), "{stem}");
    }
    let svg = fs::read_to_string(dir.join("centre-z.svg")).unwrap();
    for text in ["time [ms]", "[mm]", "Somebody et al. (2014), digitised", "five independent programs"] {
        assert!(svg.contains(text), "{text}");
    }
    let svg = fs::read_to_string(dir.join("balance.svg")).unwrap();
    assert!(svg.contains("kinetic energy: water") && svg.contains("energy [mJ]"));
    assert!(!svg.contains("never") && !svg.contains("mass"), "what is zero or no energy is left out");
}

/// Values are lines in the plot of all columns of their unit, over their span of time.
#[test]
fn values_are_drawn_as_levels_beside_all_columns_of_a_unit() {
    let dir = directory("levels");
    let histories = dir.join("history");
    fs::create_dir_all(&histories).unwrap();
    let rows = (0..=100).map(|n| 0.01 * f64::from(n)).map(|t| format!("{t},{},{}\n", (20.0 * t).sin(), 0.3 * t));
    fs::write(histories.join("tip.csv"), format!("time [s],x [m],y [m]\n{}", rows.collect::<String>())).unwrap();
    let levels = [-1.0, 1.0].map(|y| HorizontalLine { y, x: [0.4, f64::INFINITY] });
    let reference = ReferenceCurve {
        history: "tip".into(),
        plus: None,
        column: "x".into(),
        label: "published extremes".into(),
        shape: CurveShape::Levels(levels.to_vec()),
        phase: None,
    };
    plot_run(&histories, &dir, &[reference]).unwrap();
    let svg = fs::read_to_string(dir.join("tip.svg")).unwrap();
    assert!(svg.contains("published extremes") && svg.contains("x, y"), "one plot of both columns");
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

/// The drag on two parts together is a plot of its own, beside those of each.
#[test]
fn sums_of_histories_with_references_are_drawn() {
    let dir = directory("sums");
    let histories = dir.join("history");
    fs::create_dir_all(&histories).unwrap();
    for (name, factor) in [("beam", 0.7), ("cylinder", 2.0)] {
        let rows = (0..=50).map(|n| 0.02 * f64::from(n)).map(|t| format!("{t},{},{}\n", factor * t, 1.0));
        let text = format!("time [s],fx [N/m on {name}],fy [N/m on {name}]\n{}", rows.collect::<String>());
        fs::write(histories.join(format!("{name}.csv")), text).unwrap();
    }
    let reference = |plus: &str| ReferenceCurve {
        history: "beam".into(),
        plus: Some(plus.into()),
        column: "fx".into(),
        label: "published drag".into(),
        shape: CurveShape::Levels(vec![HorizontalLine { y: 2.7, x: [0.0, 1.0] }]),
        phase: None,
    };
    plot_run(&histories, &dir, &[reference("cylinder"), reference("nothing")]).unwrap();
    let svg = fs::read_to_string(dir.join("beam-and-cylinder.svg")).unwrap();
    assert!(svg.contains("published drag") && svg.contains("N/m on beam and cylinder"), "{svg}");
    assert!(!fs::read_to_string(dir.join("beam.svg")).unwrap().contains("published drag"));
    let both = HistoryTable::read(&histories.join("beam.csv"))
        .and_then(|beam| Ok(beam.plus(&HistoryTable::read(&histories.join("cylinder.csv"))?, "cylinder")))
        .unwrap();
    assert!((both.columns[1][50] - 2.7).abs() < 1e-12 && both.columns[2] == vec![2.0; 51], "{both:?}");
}

/// A swing of the run from its own start on, and one period and a half of the reference from zero on.
#[test]
fn a_periodic_reference_is_drawn_in_the_phase_of_the_run() {
    let dir = directory("phase");
    let swing = |t: f64, start: f64| (std::f64::consts::TAU * (t - start) / 0.4).sin();
    let rows = (0..=500).map(|n| 0.01 * f64::from(n)).map(|t| format!("{t},{}\n", swing(t, 0.07)));
    let histories = dir.join("history");
    fs::create_dir_all(&histories).unwrap();
    fs::write(histories.join("tip.csv"), format!("time [s],y [m]\n{}", rows.collect::<String>())).unwrap();
    let signal: Vec<[f64; 2]> = (0..60).map(|n| 0.01 * f64::from(n)).map(|t| [t, swing(t, 0.0)]).collect();
    let in_phase = |history: &str| ReferenceCurve {
        history: "tip".into(),
        plus: None,
        column: "y".into(),
        label: format!("published, by {history}"),
        shape: CurveShape::Points(signal.clone()),
        phase: Some(PhaseReference { history: history.into(), column: "y".into(), signal: signal.clone() }),
    };
    plot_run(&histories, &dir, &[in_phase("tip"), in_phase("another")]).unwrap();
    assert!(dir.join("tip-periods.png").exists(), "the periods closer by");
    let svg = fs::read_to_string(dir.join("tip-periods.svg")).unwrap();
    assert!(svg.contains("published, by tip") && svg.contains("tip, the last periods"));
    assert!(!svg.contains("published, by another"), "what has no phase has no place");
}

fn curve(y: impl Fn(f64) -> f64) -> Data {
    Data::Line((0..=50).map(f64::from).map(|x| [x, y(x)]).collect())
}

#[test]
fn plots_are_reproducible_and_hold_no_nan() {
    let odd: [(&str, Data); 5] = [
        ("constant", curve(|_| 0.25)),
        ("zero", curve(|_| 0.0)),
        ("gaps", curve(|x| if x > 20.0 && x < 30.0 { f64::NAN } else { x })),
        ("empty", Data::Dashed(vec![])),
        ("huge <&> tiny", curve(|x| 1e300 * x)),
    ];
    let (x, y) = (PlotAxis { name: "x".into(), unit: "m".into() }, PlotAxis::of_head("mass flux [kg/s]"));
    assert_eq!((y.name.as_str(), y.unit.as_str()), ("mass flux", "kg/s"));
    for (label, data) in odd {
        let series = vec![PlotSeries { label: label.into(), data }];
        let spec = PlotSpec { title: label.into(), x: x.clone(), y: y.clone(), series };
        let svg = to_svg(&spec).unwrap();
        assert_eq!(svg, to_svg(&spec).unwrap());
        assert!(svg.starts_with("<svg width=\"760\" height=\"470\" viewBox=") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("<&>"));
        assert_eq!(to_image(&spec).unwrap(), to_image(&spec).unwrap());
    }
}

/// The highest row of an image that shows a colour: text, axes and references are grey.
fn highest_colour(image: &Image) -> usize {
    let rows = image.pixels.chunks_exact(3 * image.width);
    let coloured = |pixel: &[u8]| pixel.iter().max().unwrap() - pixel.iter().min().unwrap() > 90;
    let legend = image.height / 4;
    legend + rows.skip(legend).position(|row| row.as_chunks::<3>().0.iter().any(|pixel| coloured(pixel))).unwrap()
}

/// Corners so sharp that mitres would reach beyond the data by many times the width of the curve.
#[test]
fn a_curve_in_a_png_stays_within_its_data() {
    let picture = |line: Vec<[f64; 2]>| {
        let frame = PlotSeries { label: String::new(), data: Data::Markers(vec![[0.0, -1.0], [1.0, 2.0]]) };
        let curve = PlotSeries { label: String::new(), data: Data::Line(line) };
        let (x, y) = (PlotAxis::of_head("time [s]"), PlotAxis::of_head("p [Pa]"));
        to_image(&PlotSpec { title: String::new(), x, y, series: vec![frame, curve] }).unwrap()
    };
    let flat = highest_colour(&picture(vec![[0.0, 1.0], [1.0, 1.0]]));
    for count in [50, 171, 400, 1111] {
        let saw = |i: u32| [f64::from(i) / f64::from(count), f64::from(i % 2)];
        let highest = highest_colour(&picture((0..=count).map(saw).collect()));
        assert!(highest + 3 >= flat, "{count} corners reach row {highest}, the data row {flat}");
    }
}
