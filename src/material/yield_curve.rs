//! Yield stress over plastic strain: one value, or a measured curve that is linear between its rows (theory B.10).

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Rows of plastic strain and yield stress [Pa]; beyond the last row the metal doesn't harden.
///
/// A case gives one value, rows, or a CSV file with two columns (`columns` in the schema).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct YieldCurve(Vec<[f64; 2]>);

/// The curve as a case writes it: one value, or rows.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    One(f64),
    Rows(Vec<[f64; 2]>),
}

impl YieldCurve {
    /// True if the yield stress is the same at every strain.
    pub fn is_constant(&self) -> bool {
        self.0.len() == 1
    }

    /// The yield stress at plastic strain zero [Pa].
    pub fn first_yield(&self) -> f64 {
        self.0[0][1]
    }

    /// The yield stress at plastic strain `strain` [Pa].
    #[inline(always)]
    pub fn yield_stress_at(&self, strain: f64) -> f64 {
        let next = self.0.partition_point(|row| row[0] <= strain);
        match (self.0.get(next.wrapping_sub(1)), self.0.get(next)) {
            (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (strain - a[0]) / (b[0] - a[0]),
            (Some(last), None) => last[1],
            (None, _) => self.first_yield(),
        }
    }

    /// Δ of σ_tr − 3 G Δ = σ_y(ε_p + Δ): the trial stress `trial` [Pa] falls with the slope 3 G = `three_g` [Pa]
    /// until it meets the curve, which it does in one of the curve's straight parts.
    pub fn plastic_increment(&self, trial: f64, strain: f64, three_g: f64) -> f64 {
        let (mut done, mut strength) = (0.0, self.yield_stress_at(strain));
        for &[end, stress] in self.0.iter().filter(|row| row[0] > strain) {
            let whole = end - strain;
            if trial - three_g * whole <= stress {
                let slope = (stress - strength) / (whole - done);
                return done + (trial - three_g * done - strength) / (three_g + slope);
            }
            (done, strength) = (whole, stress);
        }
        (trial - strength) / three_g
    }
}

impl TryFrom<Vec<[f64; 2]>> for YieldCurve {
    type Error = String;

    fn try_from(rows: Vec<[f64; 2]>) -> Result<Self, String> {
        match rows.first() {
            None => return Err("the curve has no rows".to_owned()),
            Some([strain, _]) if *strain != 0.0 => {
                return Err(format!("the first row is the yield stress at plastic strain 0, not at {strain}"));
            }
            Some([_, stress]) if *stress <= 0.0 => {
                return Err(format!("the yield stress of {stress} Pa isn't positive"));
            }
            Some(_) => {}
        }
        for (pair, row) in rows.windows(2).zip(2..) {
            let ([a, low], [b, high]) = (pair[0], pair[1]);
            if b <= a {
                return Err(format!("the plastic strains must increase: row {row} has {b} after {a}"));
            }
            if high < low {
                return Err(format!("the yield stress must not fall: row {row} has {high} Pa after {low} Pa"));
            }
        }
        Ok(Self(rows))
    }
}

impl From<f64> for YieldCurve {
    /// The same yield stress [Pa] at every strain.
    fn from(stress: f64) -> Self {
        Self(vec![[0.0, stress]])
    }
}

impl TryFrom<Written> for YieldCurve {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        match written {
            Written::One(stress) => vec![[0.0, stress]].try_into(),
            Written::Rows(rows) => rows.try_into(),
        }
    }
}

impl From<YieldCurve> for Written {
    fn from(curve: YieldCurve) -> Self {
        if curve.is_constant() { Self::One(curve.first_yield()) } else { Self::Rows(curve.0) }
    }
}

impl JsonSchema for YieldCurve {
    fn schema_name() -> Cow<'static, str> {
        "YieldCurve".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "One value, rows [plastic strain, yield stress], or a CSV file { table = \"file.csv\" } with such columns.",
            "columns": true,
            "anyOf": [
                { "type": ["number", "string"] },
                {
                    "type": "array",
                    "minItems": 1,
                    "items": {
                        "type": "array",
                        "prefixItems": [
                            { "type": "number", "unit": "1", "minimum": 0.0 },
                            { "type": "number", "unit": "Pa", "exclusiveMinimum": 0.0 },
                        ],
                        "minItems": 2,
                        "maxItems": 2,
                    },
                },
                {
                    "type": "object",
                    "properties": { "table": { "type": "string", "description": "The CSV file, relative to the case file." } },
                    "required": ["table"],
                    "additionalProperties": false,
                },
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::YieldCurve;

    fn curve() -> YieldCurve {
        YieldCurve::try_from(vec![[0.0, 100.0], [0.1, 200.0], [0.3, 240.0]]).unwrap()
    }

    #[test]
    fn the_curve_is_linear_between_rows_and_flat_beyond_them() {
        for (strain, stress) in [(0.0, 100.0), (0.05, 150.0), (0.1, 200.0), (0.2, 220.0), (0.3, 240.0), (9.0, 240.0)] {
            assert!((curve().yield_stress_at(strain) - stress).abs() < 1e-12);
        }
    }

    #[test]
    fn the_increment_ends_on_the_curve_whichever_part_it_is_in() {
        let three_g = 3000.0;
        for strain in [0.0, 0.04, 0.1, 0.25, 0.5] {
            for increment in [1e-6, 0.03, 0.08, 0.15, 0.28, 1.0] {
                let trial = curve().yield_stress_at(strain + increment) + three_g * increment;
                let found = curve().plastic_increment(trial, strain, three_g);
                assert!((found / increment - 1.0).abs() < 1e-9, "{strain} {increment} {found}");
            }
        }
    }

    #[test]
    fn curves_that_make_no_sense_are_refused() {
        let error = |rows: &[[f64; 2]]| YieldCurve::try_from(rows.to_vec()).unwrap_err();
        assert!(error(&[]).contains("no rows"));
        assert!(error(&[[0.1, 1.0]]).contains("plastic strain 0"));
        assert!(error(&[[0.0, 1.0], [0.2, 2.0], [0.2, 3.0]]).contains("row 3 has 0.2 after 0.2"));
        assert!(error(&[[0.0, 2.0], [0.2, 1.0]]).contains("must not fall"));
    }
}
