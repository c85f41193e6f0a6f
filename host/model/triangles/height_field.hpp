// surface() of .csg: a solid under a grid of heights, from text or a PNG picture.
#pragma once

#include <string>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Heights in rows; row 0 at y = 0, column 0 at x = 0.
struct HeightField {
    std::size_t columns = 0;
    std::vector<double> heights;
    std::size_t rows() const { return columns == 0 ? 0 : heights.size() / columns; }
};

/// Rows of numbers, '#' starts a comment line.
HeightField read_heights_text(const std::string& content, const std::string& source);

/// Brightness 0 to 1 gives the heights 0 to 100, inverted 100 to 0; the lowest row of pixels is row 0.
HeightField read_heights_png(const std::string& content, const std::string& source, bool invert);

/// Unit squares, each of four triangles about its middle; the base is 1 below the lowest height, at most 0.
TriangleSurface height_surface(const HeightField& field, bool center, const std::string& source);

/// Chooses the reader by content: PNG or text.
TriangleSurface read_height_surface(const std::string& content, const std::string& source, bool center,
                                    bool invert);

}  // namespace mortise::model_reader
