//! Lists of image observations as CSV: which photograph shows which point where.
//!
//! A header names the columns: `photo`, `id`, `x`, `y` must be there, `sigma` of both coordinates or `sigma_x` and `sigma_y`
//! may be; x, y and the standard deviations are pixels. Other columns are passed over. Without a header a line has these
//! four in this order. The rest is as in [`points`](crate::points).

use std::path::Path;

use crate::control::{image_sigmas, sigmas};
use crate::error::{Error, LineProblem};
use crate::fields::at;
use crate::json::read_text;
use crate::points::{Line, find, table};

/// A line of a list of observations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObservationRow {
    /// The photograph's name.
    pub photo: String,
    /// The point's name.
    pub id: String,
    /// x, y in the picture, pixels.
    pub image: [f64; 2],
    /// Standard deviations of x and y, pixels; none where they are not stated.
    pub sigma: Option<[f64; 2]>,
}

/// Reads a list of observations.
///
/// # Errors
/// [`ErrorKind::Line`](crate::ErrorKind::Line) with the line and the field in it,
/// [`ErrorKind::NoLines`](crate::ErrorKind::NoLines) where there is neither a header nor an observation.
pub fn read_observations(path: &Path) -> Result<Vec<ObservationRow>, Error> {
    read_text(path).and_then(|text| parse_observations(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_observations`], from text.
///
/// ```
/// use collinear_io::observations::parse_observations;
///
/// let rows = parse_observations("id,photo,x,y,sigma\nchurch,left,10.5,20.5,0.3\nchurch,right,1,2,\n")?;
/// assert_eq!((rows[0].photo.as_str(), rows[0].sigma), ("left", Some([0.3, 0.3])));
/// assert_eq!((rows[1].id.as_str(), rows[1].sigma), ("church", None));
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_observations`].
pub fn parse_observations(text: &str) -> Result<Vec<ObservationRow>, Error> {
    table(text, Columns::without_header, Columns::named, Columns::row)
}

/// Where in a line each value stands, from 0.
struct Columns {
    count: usize,
    photo: usize,
    id: usize,
    image: [usize; 2],
    sigma: Option<[(usize, &'static str); 2]>,
}

impl Columns {
    /// Two names and two numbers.
    fn without_header(fields: &[String]) -> Option<Self> {
        let numbers = fields.len() == 4 && fields[2..].iter().all(|f| f.parse::<f64>().is_ok());
        numbers.then_some(Self { count: 4, photo: 0, id: 1, image: [2, 3], sigma: None })
    }

    fn named(line: usize, header: &[String]) -> Result<Self, Error> {
        let column = |name| find(line, header, name);
        match (column("photo")?, column("id")?, column("x")?, column("y")?) {
            (Some(photo), Some(id), Some(x), Some(y)) => {
                let sigma = image_sigmas(line, header)?;
                Ok(Self { count: header.len(), photo, id, image: [x, y], sigma })
            }
            _ => {
                let (header, expected) = (header.join(" "), "photo, id, x, y, and perhaps sigma");
                Err(at(line, None, LineProblem::Header { header, expected }))
            }
        }
    }

    fn row(&self, number: usize, fields: &[String]) -> Result<ObservationRow, Error> {
        let line = Line::new(number, fields, self.count)?;
        let [x, y] = self.image;
        Ok(ObservationRow {
            photo: line.text(self.photo).to_owned(),
            id: line.text(self.id).to_owned(),
            image: [line.value(x, "x")?, line.value(y, "y")?],
            sigma: sigmas(&line, number, self.sigma)?,
        })
    }
}
