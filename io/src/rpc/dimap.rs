//! Cameras in XML: DIMAP of Airbus, and the metadata domain "RPC" of GDAL's VRT and `.aux.xml`.

use roxmltree::{Document, Node};

use super::RpcFile;
use super::fields::{Fields, short};
use super::text::TXT;
use crate::error::{Error, RpcProblem};
use crate::xml;

/// Parses the XML of a camera: DIMAP, or GDAL's.
///
/// DIMAP has two models, and the names differ: that from the ground to the image is its `Inverse_Model` (version 2:
/// Pléiades, SPOT 6 and 7) or `GroundtoImage_Values` (version 3: Pléiades Neo). Version 2 counts the centre of the first
/// pixel as (1, 1); version 3 says in `ImagetoGround_Validity_Domain` whether it is 0 or 1. Its `ERR_BIAS_ROW` and
/// `ERR_BIAS_COL` are pixels and are not taken for the error in metres.
///
/// # Errors
/// As [`read`](super::read).
pub fn parse_xml(text: &str) -> Result<RpcFile, Error> {
    let document = xml::parse(text).map_err(|e| RpcProblem::Xml { reason: e.to_string() })?;
    let named = |name: &'static str| document.descendants().find(move |n| n.has_tag_name(name));
    if let Some(model) = named("Rational_Function_Model") {
        return dimap(&document, model);
    }
    let domain =
        |n: &Node<'_, '_>| n.has_tag_name("Metadata") && n.attribute("domain") == Some("RPC");
    let found = document.descendants().find(domain);
    gdal(&document, found.ok_or(RpcProblem::NotAnRpc)?)
}

fn line_of(document: &Document<'_>, node: Node<'_, '_>) -> usize {
    document.text_pos_at(node.range().start).row as usize
}

fn content<'a>(node: Node<'a, '_>) -> &'a str {
    node.text().unwrap_or_default().trim()
}

fn dimap(document: &Document<'_>, model: Node<'_, '_>) -> Result<RpcFile, Error> {
    let below = |name: &'static str| model.descendants().find(move |n| n.has_tag_name(name));
    let missing = |field: &str| RpcProblem::Missing { field: field.to_owned() };
    if let Some(id) = below("RESOURCE_ID").filter(|n| content(*n) != "RPC00B") {
        let (line, field) = (line_of(document, id), "RESOURCE_ID".to_owned());
        let found = short(content(id));
        return Err(RpcProblem::Convention { line, field, found, expected: "RPC00B" }.into());
    }
    let coefficients = below("Inverse_Model").or_else(|| below("GroundtoImage_Values"));
    let coefficients =
        coefficients.ok_or_else(|| missing("Inverse_Model or GroundtoImage_Values"))?;
    let validity = below("RFM_Validity").ok_or_else(|| missing("RFM_Validity"))?;
    let mut fields = Fields::new(&TXT);
    for node in coefficients.children().filter(Node::is_element) {
        fields.coefficient(node.tag_name().name(), line_of(document, node), content(node))?;
    }
    for node in validity.children().filter(Node::is_element) {
        fields.scalar(node.tag_name().name(), line_of(document, node), content(node))?;
    }
    // Version 3 says where the first pixel is; before, it was at 1.
    let origin = |field: &'static str| {
        let Some(domain) = below("ImagetoGround_Validity_Domain") else { return Ok(1.0) };
        let node = domain.children().find(|n| n.has_tag_name(field));
        let node = node.ok_or_else(|| missing(field))?;
        match content(node).parse() {
            Ok(value) if value == 0.0 || value == 1.0 => Ok(value),
            _ => {
                let (line, found) = (line_of(document, node), short(content(node)));
                let (field, expected) = (field.to_owned(), "0 or 1");
                Err(RpcProblem::Convention { line, field, found, expected })
            }
        }
    };
    let (row, column) = (origin("FIRST_ROW")?, origin("FIRST_COL")?);
    let mut file = fields.finish(|p| *p)?;
    file.line_offset -= row;
    file.sample_offset -= column;
    Ok(file)
}

fn gdal(document: &Document<'_>, domain: Node<'_, '_>) -> Result<RpcFile, Error> {
    let mut fields = Fields::new(&TXT);
    for node in domain.children().filter(|n| n.has_tag_name("MDI")) {
        let (name, line) = (node.attribute("key").unwrap_or_default(), line_of(document, node));
        if !fields.scalar(name, line, content(node))? {
            fields.polynomial(name, line, content(node).split_whitespace())?;
        }
    }
    fields.finish(|p| *p)
}
