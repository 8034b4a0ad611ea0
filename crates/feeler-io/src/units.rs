//! Units of length.

use std::fmt;

/// The unit of a file's lengths. Reading converts nothing: it says what the numbers mean.
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

    /// The format's number.
    pub(crate) fn code(&self) -> i32 {
        match self {
            Self::None => 0,
            Self::Micrometres => 1,
            Self::Millimetres => 2,
            Self::Centimetres => 3,
            Self::Metres => 4,
            Self::Kilometres => 5,
            Self::Microinches => 6,
            Self::Mils => 7,
            Self::Inches => 8,
            Self::Feet => 9,
            Self::Miles => 10,
            Self::Custom { .. } => 11,
            Self::Other(code) => *code,
        }
    }

    /// Its length in metres; `None` where none is said.
    pub fn metres(&self) -> Option<f64> {
        Some(match self {
            Self::Micrometres => 1e-6,
            Self::Millimetres => 1e-3,
            Self::Centimetres => 1e-2,
            Self::Metres => 1.0,
            Self::Kilometres => 1e3,
            Self::Microinches => 2.54e-8,
            Self::Mils => 2.54e-5,
            Self::Inches => 0.0254,
            Self::Feet => 0.3048,
            Self::Miles => 1609.344,
            Self::Custom { metres, .. } => return metres.filter(|m| *m > 0.0),
            Self::None | Self::Other(_) => return None,
        })
    }

    /// What its lengths are multiplied by to be in another unit, rounded once where both are named ones; `None` where one has no length.
    pub fn ratio(&self, to: &Self) -> Option<f64> {
        // In tenths of a nanometre all named units are integers below 2^53.
        let exact = |u: &Self| {
            Some(match u {
                Self::Micrometres => 1e4,
                Self::Millimetres => 1e7,
                Self::Centimetres => 1e8,
                Self::Metres => 1e10,
                Self::Kilometres => 1e13,
                Self::Microinches => 254.0,
                Self::Mils => 254e3,
                Self::Inches => 254e6,
                Self::Feet => 3_048e6,
                Self::Miles => 16_093_440e6,
                other => other.metres()? * 1e10,
            })
        };
        Some(exact(self)? / exact(to)?)
    }

    /// The unit of a symbol: `um`, `mm`, `cm`, `m`, `km`, `uin`, `mil`, `in`, `ft` or `mi`.
    pub fn from_symbol(symbol: &str) -> Option<Self> {
        // Those with a number in the format and a symbol of their own.
        let all = (1..=10).map(Self::from_code);
        { all }.find(|u| u.symbol() == symbol)
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
