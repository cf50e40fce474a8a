//! Lists of points.

use collinear_io::ErrorKind;
use collinear_io::points::{
    ImagePointRow, PointRow, format_points, parse_image_points, parse_points, read_points,
    write_points,
};
use proptest::prelude::*;

fn world(text: &str) -> Vec<[f64; 3]> {
    parse_points(text)
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
        .into_iter()
        .map(|r| r.world)
        .collect()
}

#[test]
fn every_usual_layout_is_read() {
    let expected = [[1.0, 2.0, 3.0], [-4.5, 5e6, 0.25]];
    for text in [
        "1,2,3\n-4.5,5e6,.25\n",
        "1;2;3\n-4.5;5e6;.25\n",
        "1\t2\t3\n-4.5\t5e6\t.25",
        "  1   2  3\n-4.5 5e6 .25\n\n",
        "X,Y,Z\n1,2,3\n-4.5,5e6,.25\n",
        "\u{20}X, Y, Z\r\n1, 2, 3\r\n-4.5, 5e6, .25\r\n",
        "x y z\n1 2 3\n-4.5 5e6 .25\n",
        "# from the total station\n\nZ,code,Y,X\n3,a,2,1\n# second\n.25,b,5e6,-4.5\n",
        "a,1,2,3\nb,-4.5,5e6,.25\n",
        "17 1 2 3\n18 -4.5 5e6 .25\n",
        "id,X,Y,Z\n1,1,2,3\n2,-4.5,5e6,.25\n",
    ] {
        assert_eq!(world(text), expected, "{text}");
    }
    assert_eq!(world("id,X,Y,Z\n"), Vec::<[f64; 3]>::new());
}

#[test]
fn a_header_alone_is_a_list_and_nothing_is_not() {
    assert_eq!(parse_points("X,Y,Z\n\n# none yet\n").unwrap(), []);
    assert_eq!(parse_image_points("id,x,y").unwrap(), []);
    for text in ["", "\n", "# nothing\n", "\u{20} \n#\n"] {
        for error in [parse_points(text).unwrap_err(), parse_image_points(text).unwrap_err()] {
            assert!(matches!(error.kind(), ErrorKind::NoLines), "{error}");
            assert_eq!(error.to_string(), "is empty: neither a header nor a point is in it");
        }
    }
}

#[test]
fn names_and_image_points_are_read_where_they_are() {
    let rows =
        parse_points("y,x,id,X,Y,Z,note\n20,10,\"church, \"\"old\"\"\",1,2,3,seen\n,,,4,5,6,\n")
            .unwrap();
    assert_eq!(
        rows,
        [
            PointRow {
                id: Some("church, \"old\"".into()),
                world: [1.0, 2.0, 3.0],
                image: Some([10.0, 20.0]),
                note: Some("seen".into())
            },
            PointRow { world: [4.0, 5.0, 6.0], ..PointRow::default() },
        ]
    );
}

#[test]
fn a_bad_line_is_named_with_its_field() {
    for (text, expected) in [
        ("1,2,3\n4,5,six\n", "line 2, field 3: Z is `six`, expected a finite number"),
        ("1,2,3\n4,5,NaN\n", "line 2, field 3: Z is `NaN`, expected a finite number"),
        ("1,2,3\n4,5,inf\n", "line 2, field 3: Z is `inf`, expected a finite number"),
        ("1,2,3\n4,5,1e999\n", "line 2, field 3: Z is `1e999`, expected a finite number"),
        ("1,2,3\n4,5\n", "line 2: has 2 fields, expected 3"),
        ("1,2,3\n4,5,6,7\n", "line 2: has 4 fields, expected 3"),
        (
            "id;X;Y;Z\na;1,5;2;3\n",
            "line 2, field 2: X is `1,5`, expected a finite number (with a decimal point)",
        ),
        ("X,Y,Z\n1,2,\n", "line 2, field 3: Z is ``, expected a finite number"),
        (
            "east,north,up\n1,2,3\n",
            "line 1: the header is `east north up`, expected the columns X, Y, Z, and perhaps id, x, y, note",
        ),
        (
            "X,Y\n1,2\n",
            "line 1: the header is `X Y`, expected the columns X, Y, Z, and perhaps id, x, y, note",
        ),
        (
            "1,2\n3,4\n",
            "line 1: the header is `1 2`, expected the columns X, Y, Z, and perhaps id, x, y, note",
        ),
        ("X,Y,Z,X\n1,2,3,4\n", "line 1, field 4: the column `X` stands there twice"),
        ("X,Y,Z,x\n1,2,3,4\n", "line 1: has one of x and y without the other"),
        ("X,Y,Z,x,y\n1,2,3,4,\n", "line 2: has one of x and y without the other"),
        ("id,X,Y,Z\n\"a,1,2,3\n", "line 2: a quotation mark is not closed in this line"),
    ] {
        assert_eq!(parse_points(text).unwrap_err().to_string(), expected);
    }
}

#[test]
fn a_list_is_written_with_the_columns_it_needs() {
    let plain = PointRow { world: [1.0, 2.5, -3.0], ..PointRow::default() };
    assert_eq!(format_points(std::slice::from_ref(&plain)).unwrap(), "X,Y,Z\n1.0,2.5,-3.0\n");
    let seen = PointRow { id: Some("a,b".into()), image: Some([0.5, 1e-7]), ..plain.clone() };
    let behind = PointRow { note: Some("behind the camera".into()), ..plain.clone() };
    let rows = [seen, behind];
    assert_eq!(
        format_points(&rows).unwrap(),
        "id,X,Y,Z,x,y,note\n\"a,b\",1.0,2.5,-3.0,0.5,1e-7,\n,1.0,2.5,-3.0,,,behind the camera\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    write_points(&path, &rows).unwrap();
    assert_eq!(read_points(&path).unwrap(), rows);
    let bad = PointRow { world: [1.0, f64::NAN, 0.0], ..PointRow::default() };
    let error = write_points(&path, &[plain, bad]).unwrap_err();
    assert!(
        error.to_string().ends_with("p.csv: [1].world[1]: is NaN, expected a finite number"),
        "{error}"
    );
    assert_eq!(read_points(&path).unwrap(), rows);
}

fn number() -> impl Strategy<Value = f64> {
    prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO
}

proptest! {
    #[test]
    fn points_survive_their_file_to_the_last_bit(rows in prop::collection::vec((
        prop::option::of("[ -~äé\t]{1,12}"), prop::array::uniform3(number()),
        prop::option::of(prop::array::uniform2(number())), prop::option::of("[ -~]{1,12}"),
    ), 0..6)) {
        let rows: Vec<PointRow> = rows.into_iter().map(|(id, world, image, note)| PointRow { id, world, image, note }).collect();
        prop_assert_eq!(parse_points(&format_points(&rows).unwrap()).unwrap(), rows);
    }
}

#[test]
fn image_points_are_read_with_and_without_a_header() {
    let row = |id: Option<&str>, image| ImagePointRow { id: id.map(Into::into), image };
    for (text, expected) in [
        ("1,2\n3,4\n", vec![row(None, [1.0, 2.0]), row(None, [3.0, 4.0])]),
        ("a 1 2\nb 3 4", vec![row(Some("a"), [1.0, 2.0]), row(Some("b"), [3.0, 4.0])]),
        ("id;y;x;code\na;1;2;7\n", vec![row(Some("a"), [2.0, 1.0])]),
        ("X,Y,Z,x,y\n9,9,9,1,2\n9,9,9,,\n", vec![row(None, [1.0, 2.0])]),
        ("x,y\n", vec![]),
    ] {
        assert_eq!(parse_image_points(text).unwrap(), expected, "{text}");
    }
    for (text, expected) in [
        (
            "X,Y,Z\n1,2,3\n",
            "line 1: the header is `X Y Z`, expected the columns x, y, and perhaps id",
        ),
        ("x,y\n1,NaN\n", "line 2, field 2: y is `NaN`, expected a finite number"),
        ("x,y\n1,\n", "line 2: has one of x and y without the other"),
        ("x,y\n1\n", "line 2: has 1 fields, expected 2"),
        ("x,x,y\n1,1,1\n", "line 1, field 2: the column `x` stands there twice"),
    ] {
        assert_eq!(parse_image_points(text).unwrap_err().to_string(), expected, "{text}");
    }
}
