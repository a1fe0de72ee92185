//! Steps of a model, and everything that a checkpoint holds of it, to be compared bit by bit.

use lateen::mpm::Mpm;
use lateen::simulation::Solver;

/// Takes the longest stable step from time `t` [s]; returns when it ends.
pub fn step<const D: usize>(mpm: &mut Mpm<D>, t: f64) -> f64 {
    let dt = mpm.stable_dt();
    mpm.step(t, dt).unwrap();
    t + dt
}

/// The columns by name.
pub fn state<const D: usize>(mpm: &mut Mpm<D>) -> Vec<(String, Vec<u8>)> {
    let mut columns = Vec::new();
    mpm.columns(&mut |name, column| columns.push((name.to_owned(), column.data.bytes().to_vec())));
    columns
}

/// Puts a state back.
pub fn restore<const D: usize>(mpm: &mut Mpm<D>, saved: &[(String, Vec<u8>)]) {
    let mut stored = saved.iter();
    mpm.columns(&mut |name, column| {
        let (expected, bytes) = stored.next().unwrap();
        assert_eq!(name, expected);
        assert!(column.data.replace(bytes));
    });
    mpm.restored();
}
