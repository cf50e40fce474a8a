//! The houses round the square.

use super::facade::{Opening, Style};
use super::house::{House, Shape};
use super::houses::{
    BROWN, Body, OAK, RED, RUST, SHUTTER_BLUE, SHUTTER_GREEN, SHUTTER_RED, SLATE, door, house,
    pair, row, shop, shutters, sized,
};
use super::ink::rgb;

pub(super) fn north_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Stepped};
    use Style::{Brick, Plaster, Timber};
    let body = |x: f64, y: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, y, 0.0),
        size: (width, 11.5),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    vec![
        house(
            "north 1",
            body(-25.5, 24.3, 7.5, (8.4, 13.2), Gable, Plaster, [0xD9A75B, 0xEADFC6, RED], 0),
            vec![
                door(OAK),
                row(3.8, 3, 2.2, shutters(SHUTTER_GREEN)),
                row(6.4, 3, 2.2, shutters(SHUTTER_GREEN)),
                row(9.4, 1, 2.0, Opening::Window),
            ],
            &[3.2, 8.6],
            101,
        ),
        house(
            "north 2",
            body(
                -18.0,
                24.8,
                6.6,
                (7.2, 11.4),
                Eaves,
                Timber { from: 3.1 },
                [0xE6D9BC, 0xCDBFA2, BROWN],
                2,
            ),
            vec![shop(0x5C6B52), row(4.2, 3, 1.75, Opening::Window)],
            &[],
            102,
        ),
        house(
            "town hall",
            body(-4.5, 22.9, 15.5, (10.6, 18.6), Stepped(5), Brick, [0xB06A50, 0xDCCBA6, SLATE], 0),
            vec![
                sized(0.0, (2.1, 3.7), 5, 2.9, Opening::Arcade),
                sized(5.2, (1.15, 2.7), 5, 2.9, Opening::Arched),
                sized(9.3, (1.1, 2.0), 5, 2.15, Opening::Arched),
                sized(13.0, (2.6, 2.6), 1, 3.0, Opening::Clock),
                sized(12.9, (0.9, 1.7), 2, 5.2, Opening::Arched),
                sized(16.6, (0.9, 1.6), 1, 3.0, Opening::Arched),
            ],
            &[4.6, 8.6, 12.2],
            103,
        ),
        house(
            "north 4",
            body(
                11.0,
                24.5,
                7.0,
                (7.9, 13.4),
                Gable,
                Timber { from: 3.0 },
                [0xEBDDBF, 0xC9B894, RED],
                0,
            ),
            vec![
                shop(0x7A4A3C),
                row(4.1, 3, 1.9, Opening::Window),
                row(6.8, 3, 1.9, Opening::Window),
                row(9.5, 1, 1.8, Opening::Window),
            ],
            &[],
            104,
        ),
        house(
            "north 5",
            body(18.0, 24.0, 7.6, (8.6, 12.6), Eaves, Plaster, [0xB9C4BD, 0xECE6D6, RUST], 2),
            vec![
                pair(sized(0.8, (1.5, 1.8), 2, 3.6, Opening::Shop(rgb(0x3F5B66))), 3.8),
                row(3.9, 3, 2.3, Opening::Window),
                row(6.4, 3, 2.3, Opening::Window),
            ],
            &[3.3],
            105,
        ),
    ]
}

pub(super) fn east_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Hip, Stepped};
    use Style::{Plaster, Timber};
    let body = |x: f64, y: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, y, 270.0),
        size: (width, 11.0),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    vec![
        house(
            "east 1",
            body(27.6, 19.5, 7.5, (8.2, 13.8), Stepped(4), Plaster, [0xE3C9A1, 0xF0E6D0, RED], 0),
            vec![
                shop(0x4A5E4A),
                row(3.9, 3, 2.1, Opening::Window),
                row(6.5, 3, 2.1, Opening::Window),
                row(9.6, 2, 1.9, Opening::Window),
            ],
            &[3.3, 8.9],
            111,
        ),
        house(
            "east 2",
            body(27.2, 12.0, 8.0, (7.6, 11.8), Eaves, Plaster, [0xC98F78, 0xEBDCC4, BROWN], 3),
            vec![
                door(0x3F5546),
                row(3.8, 4, 1.95, shutters(SHUTTER_BLUE)),
                row(5.9, 4, 1.95, shutters(SHUTTER_BLUE)),
            ],
            &[3.2],
            112,
        ),
        house(
            "east 3",
            body(
                27.9,
                4.0,
                7.4,
                (8.3, 14.0),
                Gable,
                Timber { from: 3.1 },
                [0xE8D8B4, 0xC8B48E, RUST],
                0,
            ),
            vec![
                pair(sized(0.6, (1.9, 1.9), 2, 3.2, Opening::Shop(rgb(0x75523A))), 3.3),
                row(4.2, 3, 2.1, Opening::Window),
                row(6.9, 3, 2.1, Opening::Window),
                row(9.9, 1, 1.8, Opening::Window),
            ],
            &[],
            113,
        ),
        house(
            "east 4",
            body(27.4, -3.4, 8.2, (9.0, 12.8), Hip, Plaster, [0xD8CDB4, 0xF2EADA, RED], 0),
            vec![
                shop(0x8B3F37),
                row(3.9, 4, 1.95, shutters(SHUTTER_RED)),
                row(6.6, 4, 1.95, shutters(SHUTTER_RED)),
            ],
            &[3.3, 6.1],
            114,
        ),
        house(
            "east 5",
            body(27.5, -18.0, 8.0, (7.4, 12.2), Gable, Plaster, [0xA9B79B, 0xE9E2CC, BROWN], 0),
            vec![
                door(0x6B3A30),
                row(3.7, 3, 2.2, Opening::Window),
                row(5.9, 3, 2.2, Opening::Window),
                row(8.6, 1, 2.0, Opening::Window),
            ],
            &[3.1],
            115,
        ),
    ]
}

pub(super) fn west_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Stepped};
    use Style::{Brick, Plaster, Timber};
    let body = |x: f64, y: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, y, 90.0),
        size: (width, 11.0),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    vec![
        house(
            "west 1",
            body(-27.4, -26.0, 8.4, (7.6, 11.6), Eaves, Plaster, [0xE2D3AE, 0xF0E8D4, RUST], 2),
            vec![
                shop(0x4E5F6B),
                row(3.7, 4, 1.95, shutters(SHUTTER_GREEN)),
                row(5.8, 4, 1.95, Opening::Window),
            ],
            &[3.2],
            121,
        ),
        house(
            "west 2",
            body(-27.8, -17.6, 7.6, (8.5, 13.6), Gable, Plaster, [0xB8695A, 0xEAD9BE, RED], 0),
            vec![
                door(OAK),
                row(3.9, 3, 2.2, Opening::Window),
                row(6.6, 3, 2.2, Opening::Window),
                row(9.6, 1, 2.0, Opening::Window),
            ],
            &[3.3, 8.7],
            122,
        ),
        house(
            "west 3",
            body(
                -27.3,
                -10.0,
                8.6,
                (7.3, 12.0),
                Eaves,
                Timber { from: 3.0 },
                [0xE9DEC2, 0xCDBB96, BROWN],
                2,
            ),
            vec![
                pair(sized(0.6, (2.1, 1.9), 2, 3.8, Opening::Shop(rgb(0x5A6A4A))), 3.9),
                row(4.1, 4, 2.0, Opening::Window),
            ],
            &[],
            123,
        ),
        house(
            "west 4",
            body(-27.6, 6.4, 7.2, (8.2, 13.6), Stepped(4), Brick, [0xA4604A, 0xD8C8A6, RUST], 0),
            vec![
                shop(0x3F4F5C),
                row(3.9, 3, 2.0, Opening::Window),
                row(6.5, 3, 2.0, Opening::Window),
                row(9.5, 1, 2.0, Opening::Window),
            ],
            &[3.3, 8.8],
            124,
        ),
        house(
            "west 5",
            body(-27.2, 13.6, 7.4, (7.5, 12.4), Gable, Plaster, [0xCFC6B6, 0xEDE6D8, RED], 0),
            vec![
                door(0x40566A),
                row(3.7, 3, 2.1, shutters(SHUTTER_BLUE)),
                row(6.0, 3, 2.1, shutters(SHUTTER_BLUE)),
                row(8.9, 1, 2.0, Opening::Window),
            ],
            &[3.2],
            125,
        ),
    ]
}

pub(super) fn south_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Hip};
    use Style::{Plaster, Timber};
    let body = |x: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, -26.6, 180.0),
        size: (width, 10.5),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    let plain = |n: i32, pitch: f64| {
        vec![
            door(OAK),
            row(3.7, n, pitch, Opening::Window),
            row(5.9, n, pitch, shutters(SHUTTER_GREEN)),
        ]
    };
    vec![
        house(
            "south 1",
            body(26.8, 8.4, (7.6, 11.8), Eaves, Plaster, [0xD6B98C, 0xEFE5CF, RED], 2),
            plain(3, 2.3),
            &[3.2],
            131,
        ),
        house(
            "south 2",
            body(
                18.4,
                7.8,
                (7.2, 12.2),
                Gable,
                Timber { from: 3.0 },
                [0xE8DBBD, 0xCBB995, BROWN],
                0,
            ),
            vec![shop(0x5B4A3A), row(4.1, 3, 2.0, Opening::Window)],
            &[],
            132,
        ),
        house(
            "south 3",
            body(-4.4, 7.6, (7.4, 11.4), Hip, Plaster, [0xC7CBB8, 0xEFE9D8, RUST], 0),
            plain(3, 2.2),
            &[3.2],
            133,
        ),
        house(
            "south 4",
            body(-12.0, 8.0, (7.9, 12.8), Gable, Plaster, [0xD9A98A, 0xF0E2CC, RED], 0),
            plain(3, 2.3),
            &[3.2],
            134,
        ),
    ]
}
