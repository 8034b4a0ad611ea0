//! Units of length.

use std::fmt;

/// The unit of a file's lengths. Nothing is converted: it says what the numbers mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Units {
    /// Not said.
    #[default]
    None,
    /// 1e-6 m.
    Micrometres,
    /// 1e-3 m.
    Millimetres,
    /// 1e-2 m.
    Centimetres,
    /// 1 m.
    Metres,
    /// 1e3 m.
    Kilometres,
    /// 1e-6 in.
    Microinches,
    /// 1e-3 in.
    Mils,
    /// 0.0254 m.
    Inches,
    /// 12 in.
    Feet,
    /// 5280 ft.
    Miles,
    /// The file's own.
    Custom {
        /// Its name.
        name: String,
        /// Its length in metres, if stored.
        metres: Option<f64>,
    },
    /// One of the format's rarer units (yard, light year, ...), by its number there.
    Other(i32),
}

impl Units {
    /// By the format's number.
    pub(crate) fn from_code(code: i32) -> Self {
        match code {
            0 => Self::None,
            1 => Self::Micrometres,
            2 => Self::Millimetres,
            3 => Self::Centimetres,
            4 => Self::Metres,
            5 => Self::Kilometres,
            6 => Self::Microinches,
            7 => Self::Mils,
            8 => Self::Inches,
            9 => Self::Feet,
            10 => Self::Miles,
            11 => Self::Custom {
                name: String::new(),
                metres: None,
            },
            other => Self::Other(other),
        }
    }

    /// The usual symbol: `mm`, `in`, ...; `none` where there is no unit.
    pub fn symbol(&self) -> &str {
        match self {
            Self::None => "none",
            Self::Micrometres => "um",
            Self::Millimetres => "mm",
            Self::Centimetres => "cm",
            Self::Metres => "m",
            Self::Kilometres => "km",
            Self::Microinches => "uin",
            Self::Mils => "mil",
            Self::Inches => "in",
            Self::Feet => "ft",
            Self::Miles => "mi",
            Self::Custom { name, .. } if !name.is_empty() => name,
            Self::Custom { .. } => "custom",
            Self::Other(_) => "other",
        }
    }
}

impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())?;
        match self {
            Self::Custom {
                metres: Some(m), ..
            } => write!(f, " ({m} m)"),
            Self::Other(code) => write!(f, " (unit {code} of the format)"),
            _ => Ok(()),
        }
    }
}
