// Outlines of text() of .csg: fontconfig finds the font, HarfBuzz shapes the text and gives the curves.
#pragma once

#include <string>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// The arguments of text() with OpenSCAD's defaults.
struct TextStyle {
    std::string text;  ///< UTF-8
    double size = 10;  ///< the em square is size / 0.72 high, so that capital letters are about `size` high
    double spacing = 1;
    std::string font;       ///< "Name:style=Bold"; empty: Liberation Sans
    std::string direction;  ///< ltr, rtl, ttb, btt; empty: from the text
    std::string language = "en";
    std::string script;               ///< ISO 15924, or "latin"; empty: from the text
    std::string halign = "left";      ///< left, center, right: of the advance widths
    std::string valign = "baseline";  ///< baseline, top, center, bottom: of the drawn outlines
    int segments = 2;                 ///< straight pieces per curve of the font, see text_segments
};

/// Straight pieces per curve as OpenSCAD draws text of that size: an eighth of a circle's fragments, rounded
/// up, at least two.
int text_segments(double size, double fn, double fa, double fs);

/// Pieces whose union is the text: an outline with its holes each. Throws std::invalid_argument with a
/// message (without a place) for a style that does not exist. Fonts that are missing give one warning.
std::vector<Contours> text_outlines(const TextStyle& style, std::vector<std::string>& warnings);

}  // namespace mortise::model_reader
