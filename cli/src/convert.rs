//! Cameras from one program's files to another's.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, bail};
use collinear::geometry::projection::ClipConvention;
use collinear_io::blender;
use collinear_io::bundler::Bundle;
use collinear_io::camera::CameraFile;
use collinear_io::colmap::{Encoding, Reconstruction};
use collinear_io::gltf;
use collinear_io::gpu::GpuCamera;
use collinear_io::nerf;
use collinear_io::opencv::{self, Form};
use collinear_io::orientation::{self, AngleUnit};
use collinear_io::pix4d;
use collinear_io::{Document, write_atomically};
use collinear_io::{metashape, opensfm};

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Camera files.
    Camera,
    /// Bundler's `bundle.out`, without points.
    Bundler,
    /// A folder of COLMAP's.
    Colmap(Encoding),
    /// OpenSfM's `reconstruction.json`, without points.
    OpenSfm,
    /// Agisoft Metashape's exported cameras.
    Metashape,
    /// Calibrations of OpenCV's.
    OpenCv(Form),
    /// Matrices of a graphics interface, with the depths of the near and the far plane.
    Gpu(ClipConvention, f64, Option<f64>),
    /// Pix4D's calibrated camera parameters.
    Pix4d,
    /// PATB's exterior orientations.
    Patb,
    /// A table of exterior orientations, with the unit of its angles.
    Opk(AngleUnit),
    /// glTF, with the depths of the near and the far plane.
    Gltf(f64, Option<f64>),
    /// A script for Blender.
    Blender,
    /// `transforms.json` of nerfstudio.
    Nerf,
}

impl Target {
    /// The extension of one photograph's file; none where all photographs go into one output.
    fn extension(self) -> Option<&'static str> {
        match self {
            Self::Camera | Self::Gpu(..) | Self::OpenCv(Form::Json) => Some("json"),
            Self::OpenCv(Form::Yaml) => Some("yml"),
            Self::OpenCv(Form::Xml) => Some("xml"),
            Self::Colmap(_)
            | Self::Bundler
            | Self::OpenSfm
            | Self::Metashape
            | Self::Pix4d
            | Self::Patb
            | Self::Opk(_)
            | Self::Gltf(..)
            | Self::Blender
            | Self::Nerf => None,
        }
    }
}

/// Where each photograph's file goes: the output itself for a single one, else a file in that folder, named like the
/// photograph with the separators of its folders as underscores.
///
/// # Errors
/// Two photographs whose files would have one name.
pub fn outputs(
    photographs: &[(String, CameraFile)],
    target: Target,
    output: &Path,
) -> Result<Vec<PathBuf>> {
    let (Some(extension), false) = (target.extension(), photographs.len() == 1) else {
        return Ok(vec![output.to_owned()]);
    };
    let mut paths: Vec<PathBuf> = Vec::with_capacity(photographs.len());
    for (name, _) in photographs {
        let plain: String = name
            .chars()
            .map(|c| if c.is_control() || r#"/\:*?"<>|"#.contains(c) { '_' } else { c })
            .collect();
        let path = output.join(format!("{}.{extension}", plain.trim_start_matches('.')));
        if paths.contains(&path) {
            bail!(
                "two photographs would be written as {}: choose one with --photograph",
                path.display()
            );
        }
        paths.push(path);
    }
    Ok(paths)
}

/// Writes the photographs' cameras.
///
/// # Errors
/// A camera that the target cannot have, with the photograph's name; nothing is written before every camera is converted.
pub fn write(
    photographs: &[(String, CameraFile)],
    target: Target,
    output: &Path,
) -> Result<Vec<PathBuf>> {
    if photographs.is_empty() {
        bail!("no photograph is in it");
    }
    let paths = outputs(photographs, target, output)?;
    // One file for all of them.
    let one = |text: String| -> Result<Vec<PathBuf>> {
        write_atomically(output, |w| w.write_all(text.as_bytes()))?;
        Ok(vec![output.to_owned()])
    };
    // What turns one photograph's camera into text, where each has a file of its own.
    let text: &dyn Fn(&CameraFile) -> Result<String, collinear_io::Error> = match target {
        Target::Colmap(encoding) => {
            Reconstruction::from_photographs(photographs)?.write(output, encoding)?;
            return Ok(paths);
        }
        Target::Bundler => {
            return one(Bundle::from_photographs(photographs)?.to_text());
        }
        Target::OpenSfm => {
            opensfm::Reconstruction::from_photographs(photographs)?.write(output)?;
            return Ok(paths);
        }
        Target::Metashape => {
            metashape::write(photographs, output)?;
            return Ok(paths);
        }
        Target::Pix4d => return one(pix4d::to_text(photographs)?),
        Target::Patb => return one(orientation::to_patb(photographs)?),
        Target::Opk(unit) => return one(orientation::to_table(photographs, unit)?),
        Target::Gltf(near, far) => return one(gltf::to_text(photographs, near, far)?),
        Target::Nerf => return one(nerf::to_text(photographs)?),
        Target::Blender => return one(blender::to_script(photographs)?),
        Target::Camera => &Document::to_json,
        Target::OpenCv(form) => &move |camera| opencv::to_text(camera, form),
        Target::Gpu(convention, near, far) => {
            &move |camera| GpuCamera::new(camera, convention, near, far)?.to_json()
        }
    };
    let mut texts = Vec::with_capacity(photographs.len());
    for (name, camera) in photographs {
        texts.push(text(camera).map_err(|e| anyhow!("{name}: {e}"))?);
    }
    for (path, text) in paths.iter().zip(texts) {
        write_atomically(path, |w| w.write_all(text.as_bytes()))?;
    }
    Ok(paths)
}
