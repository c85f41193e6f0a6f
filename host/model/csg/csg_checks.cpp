#include "host/model/csg/csg_checks.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"

namespace mortise::model_reader {
namespace {

constexpr int kMostFlatFragments = 12;
constexpr int kMostFragments = 100000;

double any_number(const CsgNodeText& node, const CsgArgument& argument, std::string_view what) {
    if (argument.kind != CsgArgument::Kind::kNumber) {
        fail(node.source, argument.where,
             in_quotes(node.name) + ": " + std::string(what) + " is not a number; expected one");
    }
    return *node.arguments.numbers(argument);
}

/// $fn; 0 where it is not given.
double wanted_fragments(const CsgNodeText& node) {
    const CsgArgument* argument = node.arguments.find("$fn");
    if (argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined) return 0;
    const double count = any_number(node, *argument, "$fn");
    return std::isfinite(count) ? count : 3;
}

}  // namespace

std::string in_quotes(std::string_view name) { return "'" + excerpt(name) + "'"; }

void refuse_unknown_arguments(const CsgNodeText& node, std::initializer_list<std::string_view> known,
                              std::size_t most_by_position) {
    std::size_t by_position = 0;
    for (const CsgArgument& argument : node.arguments.all()) {
        if (argument.name.empty()) {
            if (++by_position > most_by_position) {
                fail(node.source, argument.where,
                     in_quotes(node.name) + " has too many arguments without a name");
            }
        } else if (argument.name[0] != '$' &&
                   std::find(known.begin(), known.end(), argument.name) == known.end()) {
            std::string list;
            for (const std::string_view name : known) list += (list.empty() ? "" : ", ") + std::string(name);
            fail(node.source, argument.where,
                 in_quotes(node.name) + " has no argument " + in_quotes(argument.name) + "; expected " +
                     list + nearest_hint(argument.name, known));
        }
    }
}

void throw_no_extent(const CsgNodeText& node, SourceLocation where, std::string_view what, double value) {
    throw NoExtent{where, in_quotes(node.name) + " with " + std::string(what) + " " + number_text(value)};
}

double finite_number(const CsgNodeText& node, const CsgArgument& argument, std::string_view what) {
    const double value = any_number(node, argument, what);
    if (!std::isfinite(value)) {
        fail(node.source, argument.where,
             in_quotes(node.name) + ": " + std::string(what) + " is " + number_text(value) +
                 "; expected a finite number");
    }
    return value;
}

double size_number(const CsgNodeText& node, const CsgArgument& argument, std::string_view what) {
    const double value = any_number(node, argument, what);
    if (!std::isfinite(value)) throw_no_extent(node, argument.where, what, value);
    return value;
}

double optional_number(const CsgNodeText& node, std::string_view name, int position, double fallback) {
    const CsgArgument* argument = node.arguments.find(name, position);
    if (argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined) return fallback;
    return finite_number(node, *argument, name);
}

bool optional_boolean(const CsgNodeText& node, std::string_view name, int position) {
    const CsgArgument* argument = node.arguments.find(name, position);
    if (argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined) return false;
    if (argument->kind != CsgArgument::Kind::kBoolean) {
        fail(node.source, argument->where,
             in_quotes(node.name) + ": " + std::string(name) + " is neither true nor false");
    }
    return argument->boolean;
}

void fail_size(const CsgNodeText& node, SourceLocation where, std::string_view what, double value,
               std::string_view expected) {
    fail(node.source, where,
         in_quotes(node.name) + ": " + std::string(what) + " is " + number_text(value) + "; expected " +
             std::string(expected));
}

double fragment_count(const CsgNodeText& node, double radius) {
    constexpr double kFinestRadius = 1.0 / (1 << 20);  // OpenSCAD's grid
    const double count = wanted_fragments(node);
    const double angle = std::max(optional_number(node, "$fa", -1, 12), 0.01);
    const double size = std::max(optional_number(node, "$fs", -1, 2), 0.01);
    if (radius < kFinestRadius) return 3;
    return std::ceil(count > 0 ? std::max(count, 3.0)
                               : std::max(std::min(360 / angle, radius * 2 * kPi / size), 5.0));
}

int fragments_of(const CsgNodeText& node, double radius) {
    const double wanted = fragment_count(node, radius);
    if (wanted > kMostFragments) {
        fail(node.source, node.where,
             in_quotes(node.name) + ": a circle of " + number_text(wanted) + " fragments; expected at most " +
                 std::to_string(kMostFragments) + ": choose another $fn");
    }
    return static_cast<int>(wanted);
}

int flat_fragments(const CsgNodeText& node, double radius) {
    if (node.facets == Facets::kExact) return fragments_of(node, radius);
    const double wanted = wanted_fragments(node);
    if (!(wanted > 0) || wanted > kMostFlatFragments) return 0;
    return std::max(3, static_cast<int>(std::ceil(wanted)));
}

void read_corners(const CsgNodeText& node, std::size_t count, double* low, double* high) {
    const std::string number = count == 2 ? "two" : "three";
    std::fill_n(high, count, 1.0);
    SourceLocation where = node.where;
    if (const CsgArgument* argument = node.arguments.find("size", 0)) {
        where = argument->where;
        if (argument->kind == CsgArgument::Kind::kNumber) {
            std::fill_n(high, count, size_number(node, *argument, "size"));
        } else if (argument->kind == CsgArgument::Kind::kList && argument->regular && argument->rows == 0 &&
                   argument->count == count) {
            std::copy_n(node.arguments.numbers(*argument), count, high);
        } else {
            fail(node.source, where,
                 in_quotes(node.name) + ": size is not a number or a list of " + number + " numbers");
        }
    }
    const bool centred = optional_boolean(node, "center", 1);
    for (std::size_t k = 0; k < count; ++k) {
        if (!(high[k] > 0) || !std::isfinite(high[k])) throw_no_extent(node, where, "size", high[k]);
    }
    for (std::size_t k = 0; k < count; ++k) {
        if (centred) high[k] /= 2;
        low[k] = centred ? -high[k] : 0;
    }
}

void refuse_both(const CsgNodeText& node, std::string_view radius, std::string_view diameter) {
    const CsgArgument* d = node.arguments.find(diameter);
    if (d == nullptr || node.arguments.find(radius) == nullptr) return;
    fail(node.source, d->where,
         in_quotes(node.name) + ": " + std::string(radius) + " and " + std::string(diameter) +
             " are both given; expected one of them");
}

double read_radius(const CsgNodeText& node) {
    refuse_both(node, "r", "d");
    double radius = 1;
    SourceLocation where = node.where;
    if (const CsgArgument* r = node.arguments.find("r", 0)) {
        radius = size_number(node, *r, "radius");
        where = r->where;
    } else if (const CsgArgument* d = node.arguments.find("d")) {
        radius = size_number(node, *d, "diameter") / 2;
        where = d->where;
    }
    if (!(radius > 0)) throw_no_extent(node, where, "radius", radius);
    return radius;
}

}  // namespace mortise::model_reader
