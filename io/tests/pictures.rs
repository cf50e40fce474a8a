//! Pictures.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use collinear_io::picture::{
    Limits, Picture, PictureFormat, decode_picture, read_picture, read_picture_within,
    write_picture,
};
use collinear_io::{ErrorKind, PictureProblem};
use proptest::prelude::*;

fn ramp(width: u32, height: u32, channels: u8) -> Picture {
    let count = width * height * u32::from(channels);
    let data = (0..count).map(|i| (i * 7 % 251) as u8).collect();
    Picture { width, height, channels, data, orientation: 1 }
}

/// The bytes of a picture as this crate writes it.
fn file(picture: &Picture, name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write_picture(&path, picture).unwrap();
    fs::read(path).unwrap()
}

fn problem(bytes: &[u8]) -> PictureProblem {
    match decode_picture(bytes, Limits::default()).unwrap_err().kind() {
        ErrorKind::Picture(problem) => problem.clone(),
        other => panic!("{other}"),
    }
}

#[test]
fn a_png_survives_with_any_number_of_channels() {
    for channels in 1..=4 {
        let picture = ramp(13, 5, channels);
        assert_eq!(decode_picture(&file(&picture, "a.png"), Limits::default()).unwrap(), picture);
    }
}

#[test]
fn a_tiff_survives() {
    for channels in [1, 3, 4] {
        let picture = ramp(13, 5, channels);
        let bytes = file(&picture, "a.TIFF");
        assert!(bytes.starts_with(b"II*\0"));
        assert_eq!(decode_picture(&bytes, Limits::default()).unwrap(), picture);
        for end in 0..bytes.len() {
            assert!(decode_picture(&bytes[..end], Limits::default()).is_err(), "{end}");
        }
        let limits = Limits { pixels: 64, ..Limits::default() };
        let error = decode_picture(&bytes, limits).unwrap_err();
        assert!(error.to_string().contains("is 13 × 5 pixels, the limit is 64"), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let error = write_picture(&folder.path().join("a.tif"), &ramp(2, 2, 2)).unwrap_err();
    assert!(error.to_string().contains("has 2 channels, TIFF takes 1, 3 or 4"), "{error}");
}

/// By hand: big endian, one strip of 2 × 1 pixels of 16 bits, and of 32 bits as floats.
#[test]
fn tiffs_of_other_programs_are_rounded_or_refused() {
    let tiff = |bits: u16, format: u16, samples: &[u8]| {
        let entries: [[u32; 3]; 9] = [
            [256, 3, 2 << 16],
            [257, 3, 1 << 16],
            [258, 3, u32::from(bits) << 16],
            [259, 3, 1 << 16],
            [262, 3, 1 << 16],
            [273, 4, 8],
            [278, 3, 1 << 16],
            [279, 4, samples.len() as u32],
            [339, 3, u32::from(format) << 16],
        ];
        let mut file = b"MM\0*".to_vec();
        file.extend((8 + samples.len() as u32).to_be_bytes());
        file.extend(samples);
        file.extend((entries.len() as u16).to_be_bytes());
        for [tag, kind, value] in entries {
            file.extend((tag as u16).to_be_bytes());
            file.extend((kind as u16).to_be_bytes());
            file.extend(1u32.to_be_bytes());
            file.extend(value.to_be_bytes());
        }
        file.extend([0; 4]);
        file
    };
    let words = tiff(16, 1, &[0x80, 0x80, 0xff, 0xff]);
    let picture = decode_picture(&words, Limits::default()).unwrap();
    assert_eq!((picture.width, picture.height, picture.channels), (2, 1, 1));
    assert_eq!(picture.data, [128, 255]);
    let floats = tiff(32, 3, &[0x3f, 0x80, 0, 0, 0, 0, 0, 0]);
    let text = problem(&floats).to_string();
    assert!(text.starts_with("is damaged, or of a kind that is not supported"), "{text}");
}

#[test]
fn samples_of_16_bits_are_rounded() {
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    // Every value once; 255/65,535 of it, rounded.
    let samples: Vec<u16> = (0..=u16::MAX).collect();
    let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_ne_bytes()).collect();
    for (channels, color) in
        [(1, ExtendedColorType::L16), (2, ExtendedColorType::La16), (4, ExtendedColorType::Rgba16)]
    {
        let mut png = Vec::new();
        let width = 256 / u32::from(channels);
        PngEncoder::new(&mut png).write_image(&bytes, width, 256, color).unwrap();
        let read = decode_picture(&png, Limits::default()).unwrap();
        assert_eq!((read.width, read.height, read.channels), (width, 256, channels));
        for (sample, byte) in samples.iter().zip(&read.data) {
            let expected = (f64::from(*sample) * 255.0 / 65_535.0).round();
            assert_eq!(f64::from(*byte), expected, "{sample}");
        }
        assert!(read.data.capacity() <= read.data.len(), "the rest is given back");
    }
}

#[test]
fn a_jpeg_survives_nearly() {
    for channels in [1, 3] {
        let mut smooth = ramp(32, 16, channels);
        for (i, sample) in smooth.data.iter_mut().enumerate() {
            *sample = (i / usize::from(channels) % 32 * 8) as u8;
        }
        let read = decode_picture(&file(&smooth, "a.JPeg"), Limits::default()).unwrap();
        assert_eq!((read.width, read.height, read.channels), (32, 16, channels));
        let worst = read.data.iter().zip(&smooth.data).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(worst <= 4, "{worst}");
    }
}

#[test]
fn a_picture_is_known_by_its_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("really_a_png.jpg");
    fs::write(&path, file(&ramp(3, 2, 3), "a.png")).unwrap();
    assert_eq!(read_picture(&path).unwrap(), ramp(3, 2, 3));
    fs::write(&path, "GIF89a and more").unwrap();
    let error = read_picture(&path).unwrap_err();
    assert!(
        error.to_string().ends_with(
            "really_a_png.jpg: is neither PNG, JPEG nor TIFF: it starts with 47 49 46 38 39 61 20 61"
        ),
        "{error}"
    );
    assert_eq!(problem(b"").to_string(), "is neither PNG, JPEG nor TIFF: it starts with nothing");
}

#[test]
fn an_unknown_extension_is_refused_before_any_work() {
    for name in ["out", "out.bmp", "out.", "png", ".png"] {
        let error = PictureFormat::from_path(Path::new(name)).unwrap_err();
        assert!(matches!(error.kind(), ErrorKind::Extension { .. }), "{name}: {error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let error = write_picture(&folder.path().join("out.bmp"), &ramp(2, 2, 1)).unwrap_err();
    assert!(
        error.to_string().ends_with(
            "out.bmp: has the unknown extension `.bmp`: name the output .png, .jpg, .jpeg, .tif or .tiff"
        ),
        "{error}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_a_format_cannot_hold_is_refused_and_the_old_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.jpg");
    fs::write(&path, "old").unwrap();
    let refuse = |picture: &Picture| match write_picture(&path, picture).unwrap_err().kind() {
        ErrorKind::Picture(problem) => problem.to_string(),
        other => panic!("{other}"),
    };
    assert_eq!(
        refuse(&ramp(2, 2, 4)),
        "has 4 channels, JPEG takes 1 or 3: write a PNG, or drop the opacity"
    );
    assert_eq!(
        refuse(&ramp(65_536, 1, 1)),
        "is 65536 × 1 pixels, the limit is 65535 a side in a JPEG"
    );
    assert_eq!(refuse(&ramp(0, 2, 1)), "is 0 × 2 pixels: a picture needs at least one");
    assert_eq!(
        refuse(&Picture { channels: 5, ..ramp(1, 1, 1) }),
        "has 5 channels, a picture takes 1 to 4"
    );
    let short = Picture { height: 3, ..ramp(2, 2, 3) };
    assert_eq!(refuse(&short), "has 12 samples, its size needs 18");
    let absurd = Picture { width: u32::MAX, height: u32::MAX, ..ramp(2, 2, 3) };
    assert!(refuse(&absurd).starts_with("has 12 samples"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_header_without_pixels_or_with_too_many_is_refused_before_decoding() {
    let png = file(&ramp(3, 2, 3), "a.png");
    let sized = |width: u32, height: u32| {
        let mut bytes = png.clone();
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        bytes
    };
    assert_eq!(problem(&sized(0, 2)), PictureProblem::Empty { width: 0, height: 2 });
    assert_eq!(
        problem(&sized(u32::MAX, u32::MAX)).to_string(),
        "is 4294967295 × 4294967295 pixels, the limit is 268435456 pixels"
    );
    let jpeg = file(&ramp(3, 2, 3), "a.jpg");
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    let sized = |width: u16, height: u16| {
        let mut bytes = jpeg.clone();
        bytes[frame + 5..frame + 7].copy_from_slice(&height.to_be_bytes());
        bytes[frame + 7..frame + 9].copy_from_slice(&width.to_be_bytes());
        bytes
    };
    assert_eq!(problem(&sized(3, 0)), PictureProblem::Empty { width: 3, height: 0 });
    assert!(matches!(problem(&sized(65_535, 65_535)), PictureProblem::TooLarge { .. }));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, &png).unwrap();
    let small = |pixels, file_bytes| read_picture_within(&path, Limits { pixels, file_bytes });
    assert!(small(6, 1 << 20).is_ok());
    assert!(matches!(
        small(5, 1 << 20).unwrap_err().kind(),
        ErrorKind::Picture(PictureProblem::TooLarge { .. })
    ));
    assert!(matches!(small(6, 20).unwrap_err().kind(), ErrorKind::TooLong { limit: 20, .. }));
}

#[test]
fn a_cut_off_picture_is_never_read() {
    let png = file(&ramp(40, 30, 3), "a.png");
    // The last twelve bytes of a PNG say only that it ends.
    for end in 0..png.len() - 12 {
        assert!(decode_picture(&png[..end], Limits::default()).is_err(), "{end} of {}", png.len());
    }
    assert_eq!(problem(&png[..png.len() / 2]), PictureProblem::Truncated { bytes: png.len() / 2 });
    let jpeg = file(&ramp(40, 30, 3), "a.jpg");
    for end in 3..jpeg.len() {
        assert_eq!(problem(&jpeg[..end]), PictureProblem::Truncated { bytes: end });
    }
    // What some cameras append after the end is passed over.
    let mut appended = jpeg.clone();
    appended.extend(b"a video");
    assert!(decode_picture(&appended, Limits::default()).is_ok());
}

#[test]
fn the_orientation_is_told_and_not_applied() {
    let jpeg = file(&ramp(3, 2, 3), "a.jpg");
    let upright = decode_picture(&jpeg, Limits::default()).unwrap();
    // An APP1 block with a big-endian TIFF of one entry: tag 0x0112, type SHORT, count 1, value 6.
    let exif = b"\xff\xe1\x00\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    let mut bytes = jpeg[..2].to_vec();
    bytes.extend(exif);
    bytes.extend(&jpeg[2..]);
    let turned = decode_picture(&bytes, Limits::default()).unwrap();
    assert_eq!(turned.orientation, 6);
    assert_eq!((turned.width, turned.height, &turned.data), (3, 2, &upright.data));
}

#[test]
fn a_real_photograph_is_read() {
    let Some(path) = crate::shared_data("berlin/01.jpg") else { return };
    let picture = read_picture(&path).unwrap();
    assert_eq!((picture.width, picture.height, picture.channels), (3264, 2448, 3));
    assert_eq!(picture.orientation, 1);
}

/// A PNG and a JPEG, written once.
static FILES: LazyLock<[Vec<u8>; 2]> =
    LazyLock::new(|| ["a.png", "a.jpg"].map(|name| file(&ramp(19, 11, 3), name)));

proptest! {
    #[test]
    fn a_damaged_picture_is_an_error_or_a_picture_of_the_stated_size(
        jpeg in any::<bool>(), edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        end in any::<prop::sample::Index>(), cut in any::<bool>(),
    ) {
        let mut bytes = FILES[usize::from(jpeg)].clone();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        if let Ok(p) = decode_picture(&bytes, Limits { pixels: 1 << 16, file_bytes: 1 << 20 }) {
            prop_assert_eq!(p.data.len(), p.width as usize * p.height as usize * usize::from(p.channels));
        }
    }
}
