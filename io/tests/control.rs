//! Lists of control points and of observations.

use collinear_io::control::parse_control;
use collinear_io::observations::parse_observations;

#[test]
fn columns_go_by_name_or_by_place() {
    let rows = parse_control("x y X Y Z id\n1 2 3 4 5 a\n").unwrap();
    assert_eq!((rows[0].world, rows[0].image), ([3.0, 4.0, 5.0], Some([1.0, 2.0])));
    assert_eq!(rows[0].id.as_deref(), Some("a"));
    for text in ["3;4;5;1;2\n", "a;3;4;5;1;2\n"] {
        let rows = parse_control(text).unwrap();
        assert_eq!((rows[0].world, rows[0].image), ([3.0, 4.0, 5.0], Some([1.0, 2.0])));
        assert_eq!((rows[0].image_sigma, rows[0].world_sigma), (None, None));
    }
    let rows = parse_control("X,Y,Z,x,y,sigma_y,sigma_x\n3,4,5,1,2,0.2,0.1\n").unwrap();
    assert_eq!(rows[0].image_sigma, Some([0.1, 0.2]));
    let rows = parse_observations("sigma_x,sigma_y,y,x,id,photo\n0.1,0.2,2,1,a,p\n").unwrap();
    assert_eq!((rows[0].image, rows[0].sigma), ([1.0, 2.0], Some([0.1, 0.2])));
    let rows = parse_observations("p\ta b\t1\t2\n").unwrap();
    assert_eq!((rows[0].photo.as_str(), rows[0].id.as_str()), ("p", "a b"));
}

#[test]
fn what_is_wrong_has_its_line_and_field() {
    for (text, message) in [
        ("X,Y,Z,x\n", "line 1: the header is `X Y Z x`, expected the columns X, Y, Z, x, y"),
        ("X,Y,Z,x,y,sigma,sigma_x\n", "line 1: the header is"),
        ("X,Y,Z,x,y,sigma_x\n", "expected the columns sigma alone, or sigma_x and sigma_y"),
        ("X,Y,Z,x,y,sigma_X,sigma_Y\n", "all of sigma_X, sigma_Y, sigma_Z or none of them"),
        ("X,Y,Z,x,y\n1,2,3,4\n", "line 2: has 4 fields, expected 5"),
        ("X,Y,Z,x,y\n1,2,3,4,\n", "line 2: has one of x and y without the other"),
        (
            "X,Y,Z,x,y,sigma\n1,2,3,4,5,-0.5\n",
            "line 2, field 6: sigma is -0.5, expected a number above 0",
        ),
        (
            "X,Y,Z,x,y,sigma\n1,2,3,4,5,inf\n",
            "line 2, field 6: sigma is `inf`, expected a finite number",
        ),
        ("X,Y,Z,x,y,sigma_X,sigma_Y,sigma_Z\n1,2,3,4,5,1,,1\n", "line 2, field 7: sigma_Y is ``"),
        ("1,2,3,4,nan\n", "line 1, field 5: y is `nan`"),
        ("", "is empty"),
    ] {
        let error = parse_control(text).unwrap_err().to_string();
        assert!(error.contains(message), "{text:?}: {error}");
    }
    for (text, message) in [
        ("photo,x,y\n", "expected the columns photo, id, x, y"),
        ("photo,id,x,y\np,a,1,\n", "line 2, field 4: y is ``"),
        ("photo,id,x,y,sigma\np,a,1,2,0\n", "line 2, field 5: sigma is 0"),
    ] {
        let error = parse_observations(text).unwrap_err().to_string();
        assert!(error.contains(message), "{text:?}: {error}");
    }
}
