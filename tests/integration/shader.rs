//! Shader source, run by a small interpreter of its own in `f32`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::collections::HashMap;

use collinear::camera::{Brown, BrownCamera, InteriorOrientation};
use collinear::geometry::Affine2;
use collinear::mapping::polynomial::{Bilinear, Cubic, Quadratic};
use collinear::mapping::shader::{Language, ShaderMap, source};
use collinear::mapping::{DistortMap, FractionalLinear, Map};
use collinear::{Error, ProjectionError};
use nalgebra::Point2;
use serde_json::Value as Json;

use crate::support::numbers;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Value {
    Number(f32),
    Vector([f32; 2]),
    Truth(bool),
}

/// Runs the functions of one text.
struct Interpreter {
    tokens: Vec<String>,
    place: usize,
    names: HashMap<String, Value>,
}

impl Interpreter {
    /// The result of the function `name`.
    fn call(text: &str, name: &str, pixel: [f32; 2]) -> Value {
        let text = text.replace("vec2<f32>", "vec2");
        let start = text.find(&format!(" {name}(")).unwrap();
        let body = &text[start + text[start..].find('{').unwrap() + 1..];
        let body = &body[..body.find('}').unwrap()];
        let mut names = HashMap::from([("pixel".to_owned(), Value::Vector(pixel))]);
        for line in body.lines().map(str::trim).filter(|l| !l.is_empty()) {
            let line = line.strip_suffix(';').unwrap();
            let (name, expression) = match line.strip_prefix("return ") {
                Some(expression) => (None, expression),
                None => {
                    let (left, right) = line.split_once(" = ").unwrap();
                    let (keyword, name) = left.split_once(' ').unwrap();
                    assert!(["let", "vec2", "float"].contains(&keyword), "{line}");
                    (Some(name.to_owned()), right)
                }
            };
            let mut run = Self { tokens: tokens(expression), place: 0, names };
            let value = run.conjunction();
            assert_eq!(run.place, run.tokens.len(), "{expression}");
            names = run.names;
            match name {
                Some(name) => assert!(names.insert(name, value).is_none()),
                None => return value,
            }
        }
        panic!("no result")
    }

    fn peek(&self) -> &str {
        self.tokens.get(self.place).map_or("", String::as_str)
    }

    fn take(&mut self, token: &str) -> bool {
        let found = self.peek() == token;
        self.place += usize::from(found);
        found
    }

    fn conjunction(&mut self) -> Value {
        let mut left = self.comparison();
        while self.take("&&") {
            let (Value::Truth(a), Value::Truth(b)) = (left, self.comparison()) else { panic!() };
            left = Value::Truth(a && b);
        }
        left
    }

    fn comparison(&mut self) -> Value {
        let left = self.sum();
        let less = self.take("<");
        if !less && !self.take(">") {
            return left;
        }
        let (Value::Number(a), Value::Number(b)) = (left, self.sum()) else { panic!() };
        Value::Truth(if less { a < b } else { a > b })
    }

    fn sum(&mut self) -> Value {
        let mut left = self.product();
        loop {
            let plus = self.take("+");
            if !plus && !self.take("-") {
                return left;
            }
            let right = self.product();
            left = combine(left, right, |a, b| if plus { a + b } else { a - b });
        }
    }

    fn product(&mut self) -> Value {
        let mut left = self.factor();
        loop {
            let times = self.take("*");
            if !times && !self.take("/") {
                return left;
            }
            let right = self.factor();
            left = match (left, right) {
                (Value::Vector(v), Value::Number(n)) => {
                    Value::Vector(v.map(|c| if times { c * n } else { c / n }))
                }
                _ => combine(left, right, |a, b| if times { a * b } else { a / b }),
            };
        }
    }

    fn factor(&mut self) -> Value {
        if self.take("(") {
            let value = self.conjunction();
            assert!(self.take(")"));
            return value;
        }
        if self.take("-") {
            let Value::Number(n) = self.factor() else { panic!() };
            return Value::Number(-n);
        }
        let word = self.peek().to_owned();
        self.place += 1;
        if let Ok(n) = word.parse::<f32>() {
            // Both languages tell floats by a point or an exponent.
            assert!(word.contains(['.', 'e']), "{word}");
            return Value::Number(n);
        }
        match word.as_str() {
            "true" => return Value::Truth(true),
            "vec2" => {
                assert!(self.take("("));
                let Value::Number(x) = self.sum() else { panic!() };
                assert!(self.take(","));
                let Value::Number(y) = self.sum() else { panic!() };
                assert!(self.take(")"));
                return Value::Vector([x, y]);
            }
            _ => {}
        }
        let (name, component) =
            word.split_once('.').map_or((word.as_str(), None), |(n, c)| (n, Some(c)));
        match (self.names[name], component) {
            (value, None) => value,
            (Value::Vector(v), Some("x")) => Value::Number(v[0]),
            (Value::Vector(v), Some("y")) => Value::Number(v[1]),
            other => panic!("{word} {other:?}"),
        }
    }
}

fn combine(a: Value, b: Value, f: impl Fn(f32, f32) -> f32) -> Value {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => Value::Number(f(a, b)),
        (Value::Vector(a), Value::Vector(b)) => Value::Vector([f(a[0], b[0]), f(a[1], b[1])]),
        other => panic!("{other:?}"),
    }
}

fn tokens(text: &str) -> Vec<String> {
    let c: Vec<char> = text.chars().collect();
    let (mut found, mut i) = (Vec::new(), 0);
    while i < c.len() {
        let start = i;
        if c[i].is_whitespace() {
            i += 1;
            continue;
        } else if c[i].is_ascii_alphanumeric() {
            let number = c[i].is_ascii_digit();
            while i < c.len()
                && (c[i].is_ascii_alphanumeric()
                    || "._".contains(c[i])
                    || (number && "+-".contains(c[i]) && c[i - 1] == 'e'))
            {
                i += 1;
            }
        } else {
            i += if c[i] == '&' { 2 } else { 1 };
        }
        found.push(c[start..i].iter().collect());
    }
    found
}

/// What both languages answer at a pixel.
fn run<'a>(map: impl Into<ShaderMap<'a>>, pixel: Point2<f64>) -> ([f64; 2], bool) {
    let map = map.into();
    let centre = Point2::new(960.0, 540.0);
    let answers = [Language::Glsl, Language::Wgsl].map(|language| {
        let text = source(map, language, "lookup", &centre).unwrap();
        let p = [pixel.x as f32, pixel.y as f32];
        (Interpreter::call(&text, "lookup", p), Interpreter::call(&text, "lookup_shows", p))
    });
    assert_eq!(answers[0], answers[1]);
    let (Value::Vector(v), Value::Truth(shows)) = answers[0] else { panic!() };
    (v.map(f64::from), shows)
}

fn oracles() -> Json {
    serde_json::from_str(include_str!("../data/oracles/shader.json")).unwrap()
}

fn array<const N: usize>(v: &Json) -> [f64; N] {
    numbers(v).try_into().unwrap()
}

#[test]
fn shaders_answer_what_mpmath_and_opencv_do() {
    let oracles = oracles();
    let c = |name: &str, i: usize| oracles[name]["coefficients"][i].clone();
    let affine = Affine2::from_coefficients(array(&c("affine", 0)), array(&c("affine", 1)));
    let [p, q, r, e] = [0, 1, 2, 3].map(|i| array(&c("fractional", i)));
    let fractional = FractionalLinear::from_coefficients(p, q, r, e).unwrap();
    let quadratic =
        Quadratic::from_coefficients(array(&c("quadratic", 0)), array(&c("quadratic", 1))).unwrap();
    let cubic = Cubic::from_coefficients(array(&c("cubic", 0)), array(&c("cubic", 1))).unwrap();
    let k = numbers(&oracles["distort"]["camera"]);
    let l = numbers(&oracles["distort"]["lens"]);
    let interior = InteriorOrientation::from_opencv(k[0], k[1], k[2], k[3]).unwrap();
    let lens = Brown::new([l[0], l[1], l[4]], [l[2], l[3]]).unwrap();
    let distort = DistortMap::new(BrownCamera::new(interior, lens));
    let mut hidden = 0;
    for (name, map) in [
        ("affine", ShaderMap::from(&affine)),
        ("fractional", ShaderMap::from(&fractional)),
        ("quadratic", ShaderMap::from(&quadratic)),
        ("cubic", ShaderMap::from(&cubic)),
        ("distort", ShaderMap::from(&distort)),
    ] {
        for (i, pixel) in oracles["pixels"].as_array().unwrap().iter().enumerate() {
            let [x, y] = array(pixel);
            let ([u, v], shows) = run(map, Point2::new(x, y));
            let expected = oracles[name]["shown"][i].as_bool().unwrap_or(true);
            assert_eq!(shows, expected, "{name} {pixel}");
            hidden += usize::from(!expected);
            let [eu, ev]: [f64; 2] = array(&oracles[name]["texture"][i]);
            let size = eu.abs().max(ev.abs());
            if shows {
                let far = f64::hypot(u - eu, v - ev);
                assert!(far < 2.0f64.powi(-21) * size.max(1000.0), "{name} {pixel} {far} {size}");
            }
        }
    }
    assert!(hidden == 2);
}

#[test]
fn far_textures_are_exact_near_the_centre() {
    // 60,000 texels away, with coordinates that f32 has to 1/256: half of that is lost in the constant and half in the sum.
    let map = FractionalLinear::from_coefficients(
        [60_123.456, 1.1, 0.02],
        [41_000.789, -0.03, 0.9],
        [1.0, 1e-6, 2e-6],
        [1.0, 0.0, 0.0],
    )
    .unwrap();
    for i in 0..200 {
        let p = Point2::new(960.5 + f64::from(i % 20), 530.5 + f64::from(i / 20));
        let ([u, v], shows) = run(&map, p);
        let far = map.at(&p).unwrap() - Point2::new(u, v);
        assert!(shows && far.amax() < 1.02 / 256.0, "{far}");
    }
}

#[test]
fn fitted_polynomials_and_skewed_cameras_are_written_too() {
    let screen: Vec<Point2<f64>> =
        (0..25).map(|i| Point2::new(f64::from(i % 5) * 400.0, f64::from(i / 5) * 250.0)).collect();
    let texture: Vec<_> = screen
        .iter()
        .map(|p| Point2::new(p.x + 1e-5 * p.x * p.y, 700.0 - p.y + 1e-8 * p.x * p.x * p.y))
        .collect();
    let bilinear = Bilinear::fit(&screen, &texture).unwrap().map;
    let cubic = Cubic::fit(&screen, &texture).unwrap().map;
    let axes = nalgebra::Matrix3::new(1200.0, 15.0, 950.0, 0.0, 1210.0, 560.0, 0.0, 0.0, 1.0);
    let interior = InteriorOrientation::from_matrix(&axes).unwrap();
    let lens = Brown::new([-0.2, 0.0, 0.0], [2e-3, -1e-3]).unwrap();
    let distort = DistortMap::new(BrownCamera::new(interior, lens));
    for i in 0..100 {
        let p = Point2::new(f64::from(i % 10) * 190.0 + 0.5, f64::from(i / 10) * 100.0 + 0.5);
        for (map, text) in [
            (&bilinear as &dyn Map, ShaderMap::from(&bilinear)),
            (&cubic, ShaderMap::from(&cubic)),
            (&distort, ShaderMap::from(&distort)),
        ] {
            let ([u, v], shows) = run(text, p);
            assert!(shows && (map.at(&p).unwrap() - Point2::new(u, v)).norm() < 1e-3);
        }
    }
    // Beyond the fold radius of this barrel nothing is shown.
    let fold = Point2::new(950.0 + 1200.0 * 3.0, 560.0);
    assert!(distort.at(&fold).is_err() && !run(&distort, fold).1);
}

#[test]
fn what_no_shader_can_hold_is_refused() {
    let map = Affine2::identity();
    let origin = Point2::origin();
    for name in ["", "1a", "a b", "gl_x", "a__b", "ä", "a-b", "_a", "a_"] {
        let text = source(&map, Language::Glsl, name, &origin);
        assert!(matches!(text, Err(Error::Unknown { .. })), "{name}");
    }
    let large = Affine2::from_coefficients([0.0, 1e39, 0.0], [0.0, 0.0, 1.0]);
    assert!(matches!(
        source(&large, Language::Glsl, "f", &origin),
        Err(Error::OutOfRange { value: 1e39, .. })
    ));
    let nan = Point2::new(f64::NAN, 0.0);
    assert!(matches!(
        source(&map, Language::Wgsl, "f", &nan),
        Err(Error::Projection(ProjectionError::NotFinite))
    ));
    let horizon =
        FractionalLinear::from_coefficients([1.0; 3], [1.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
            .unwrap();
    let Err(error) = source(&horizon, Language::Wgsl, "f", &origin) else { panic!("horizon") };
    assert_eq!(error, Error::Projection(horizon.at(&origin).unwrap_err()));
    // A lens without errors has no fold.
    let interior = InteriorOrientation::new([100.0; 2], Point2::new(50.0, 50.0), 0.0).unwrap();
    let ideal = DistortMap::new(BrownCamera::new(interior, Brown::none()));
    assert_eq!(run(&ideal, Point2::new(1e4, -1e4)), ([1e4, -1e4], true));
}
