// The solids of a .csg file: cube, sphere, cylinder and the matrix of multmatrix.
#pragma once

#include "host/model/csg_arguments.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// What a primitive's constructor needs to know about its node.
struct CsgNodeText {
    std::string_view name;  ///< e.g. "cylinder"
    const CsgArguments& arguments;
    const std::string& source;
    SourceLocation where;
    std::string surface;  ///< name for its surfaces
};

/// Each appends nodes to the model and returns the top one; throws Error(kInput) with the place.
std::uint32_t add_csg_cube(Model& model, const CsgNodeText& node);
std::uint32_t add_csg_sphere(Model& model, const CsgNodeText& node);
std::uint32_t add_csg_cylinder(Model& model, const CsgNodeText& node);

/// The 4×4 matrix of a multmatrix node: regular and finite, last row 0, 0, 0, 1.
Affine csg_matrix(const CsgNodeText& node);

}  // namespace mortise::model_reader
