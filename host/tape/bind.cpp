// Binding a compiled model to its root box: box-local surfaces, merged where equal, with float copies.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/common/sort_unique.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/polyhedron.hpp"
#include "host/tape/surface_merge.hpp"

namespace mortise::tape {
namespace {

SurfaceBounds make_bounds(const Surface& s) {
    SurfaceBounds b{};
    for (int i = 0; i < 12; ++i) b.map[i] = static_cast<float>(s.map[i]);
    for (int i = 0; i < 4; ++i) b.form[i] = static_cast<float>(s.form[i]);
    for (int i = 0; i < 3; ++i) {
        const double size = std::fabs(s.map[4 * i]) + std::fabs(s.map[4 * i + 1]) +
                            std::fabs(s.map[4 * i + 2]) + std::fabs(s.map[4 * i + 3]);
        // Rounding of the coefficients and of three products and sums: at most 5 · 2^-24 of the size.
        b.error[i] = static_cast<float>(size * std::ldexp(1.0, -21));
    }
    b.kind = s.kind;
    b.first_op = s.first_op;
    b.op_count = s.op_count;
    return b;
}

/// A region's formula stands before its select.
std::vector<Namesake> find_namesakes(const CompiledModel& compiled, const BoundModel& bound) {
    std::vector<bool> has_several(bound.surfaces.size(), false);
    for (std::size_t i = 0; i < compiled.surfaces.size(); ++i) {
        const std::uint32_t target = bound.bound_surface[i];
        if (compiled.surfaces[i].name != bound.surface_name[target]) has_several[target] = true;
    }
    std::vector<Namesake> namesakes;
    std::vector<std::uint32_t> own;  // of the region at hand
    const auto add = [&](std::uint32_t surface) {
        if (has_several[bound.bound_surface[surface]]) own.push_back(surface);
    };
    for (const std::uint32_t word : compiled.tape) {
        const std::uint32_t operation = tape_operation(word);
        if (operation == kTapeLiteral) add(tape_surface(word));
        if (operation == kTapeSpatial) {
            for (const std::uint32_t surface : compiled.polyhedra[tape_surface(word)].surface) add(surface);
        }
        if (operation != kTapeSelect && operation != kTapeSelectConst) continue;
        sort_unique(own);
        for (const std::uint32_t surface : own)
            namesakes.push_back({bound.bound_surface[surface], tape_region(word), surface});
        own.clear();
    }
    std::sort(namesakes.begin(), namesakes.end(), [](const Namesake& a, const Namesake& b) {
        return std::tie(a.surface, a.region, a.compiled) < std::tie(b.surface, b.region, b.compiled);
    });
    return namesakes;
}

}  // namespace

BoundModel bind(const CompiledModel& compiled, const Vec3& origin, double side, const MergeDistances& merge) {
    BoundModel bound;
    bound.origin = origin;
    bound.side = side;
    bound.expression_ops = compiled.expression_ops;
    if (bound.expression_ops.empty()) bound.expression_ops.push_back({});
    SurfaceMerge merged(compiled, origin, side);
    bound.nearly_equal = merged.merge_equal(bound.expression_ops, merge.any);
    if (merge.alike > merge.any) bound.alike = merged.merge_alike(compiled, merge.alike);
    std::vector<std::uint32_t>& target = bound.bound_surface;
    target.resize(compiled.surfaces.size());
    const std::vector<std::uint32_t>& flipped = merged.flipped;
    for (std::size_t i = 0; i < compiled.surfaces.size(); ++i) {
        const double size = compiled.surface_size[i] / side;
        if (merged.target[i] != i) {
            target[i] = target[merged.target[i]];
            bound.surface_size[target[i]] = std::min(bound.surface_size[target[i]], size);
            continue;
        }
        target[i] = static_cast<std::uint32_t>(bound.surfaces.size());
        bound.surfaces.push_back(merged.local(i));
        bound.bounds.push_back(make_bounds(merged.local(i)));
        bound.surface_name.push_back(compiled.surfaces[i].name);
        bound.surface_size.push_back(size);
    }
    bound.namesakes = find_namesakes(compiled, bound);
    for (const double size : compiled.region_size) bound.region_size.push_back(size / side);
    for (const SurfaceHint& hint : compiled.hints) {
        SurfaceHint local{hint.kind, {}, {}, hint.max_size / side};
        for (std::size_t j = 0; j < 3; ++j) local.at[j] = (hint.at[j] - origin[j]) / side;
        for (const auto& group : hint.groups) {
            std::vector<std::uint32_t> surfaces;
            for (const std::uint32_t surface : group) surfaces.push_back(target[surface]);
            sort_unique(surfaces);
            local.groups.push_back(std::move(surfaces));
        }
        bound.hints.push_back(std::move(local));
    }
    for (PeriodicSurfaces pair : compiled.periodic) {
        for (std::uint32_t* surface : {&pair.first, &pair.second})
            if (*surface != PeriodicSurfaces::kNoSurface) *surface = target[*surface];
        bound.periodic.push_back(pair);
    }
    bound.tape = compiled.tape;
    for (std::uint32_t& word : bound.tape) {
        if (tape_operation(word) != kTapeLiteral) continue;
        const std::uint32_t surface = tape_surface(word);
        word = make_literal(target[surface], tape_negated(word) ^ flipped[surface]);
    }
    for (const WorldPolyhedron& world : compiled.polyhedra) {
        BoundPolyhedron local;
        local.shape = world.shape;
        for (Vec3& point : local.shape.points) {
            for (std::size_t j = 0; j < 3; ++j) point[j] = (point[j] - origin[j]) / side;
        }
        for (const std::uint32_t surface : world.surface) local.surface.push_back(target[surface]);
        local.bounds = bounds_of(local.shape);
        bound.polyhedra.push_back(std::move(local));
    }
    return bound;
}

}  // namespace mortise::tape
