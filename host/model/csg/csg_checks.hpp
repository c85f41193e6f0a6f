// Checks of the arguments of .csg nodes, with messages that name node and argument.
#pragma once

#include <initializer_list>
#include <string>

#include "host/model/csg/csg_arguments.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// What a node's constructor needs to know about its text.
struct CsgNodeText {
    std::string_view name;  ///< e.g. "cylinder"
    const CsgArguments& arguments;
    const std::string& source;
    SourceLocation where;
    std::string surface;  ///< name for its surfaces
    Facets facets{};      ///< how curves are taken
};

std::string in_quotes(std::string_view name);

/// Arguments with a $ concern the number of fragments and animation; they are always allowed.
void refuse_unknown_arguments(const CsgNodeText& node, std::initializer_list<std::string_view> known,
                              std::size_t most_by_position);

/// Thrown while a node is read: its object has a size that is zero, negative or not finite. OpenSCAD makes
/// nothing of it, so it is left out (CsgScene::leave_out).
struct NoExtent {
    SourceLocation where;
    std::string what;  ///< e.g. "'cube' with size 0"
};

[[noreturn]] void throw_no_extent(const CsgNodeText& node, SourceLocation where, std::string_view what,
                                  double value);

double finite_number(const CsgNodeText& node, const CsgArgument& argument, std::string_view what);

/// A number that makes the object empty where it is not finite.
double size_number(const CsgNodeText& node, const CsgArgument& argument, std::string_view what);

/// The number of that name, or the fallback where it is missing or undef.
double optional_number(const CsgNodeText& node, std::string_view name, int position, double fallback);

/// true or false (also as 1 or 0); false where it is missing or undef.
bool optional_boolean(const CsgNodeText& node, std::string_view name, int position);

/// Corners of a cube (count 3) or square (count 2) by its `size` and `center`; low and high: count numbers.
void read_corners(const CsgNodeText& node, std::size_t count, double* low, double* high);

/// Fails if a radius and a diameter are both given by name.
void refuse_both(const CsgNodeText& node, std::string_view radius, std::string_view diameter);

/// Radius of a sphere or circle by its `r` or `d`.
double read_radius(const CsgNodeText& node);

[[noreturn]] void fail_size(const CsgNodeText& node, SourceLocation where, std::string_view what,
                            double value, std::string_view expected);

/// OpenSCAD's number of fragments of a full circle: $fn, or by $fa and $fs. It takes 3 where $fn is not
/// finite.
int fragments_of(const CsgNodeText& node, double radius);
/// The same, however many.
double fragment_count(const CsgNodeText& node, double radius);

/// Number of flat fragments that are meant for a circle of that radius; 0: a true curve.
int flat_fragments(const CsgNodeText& node, double radius);

}  // namespace mortise::model_reader
