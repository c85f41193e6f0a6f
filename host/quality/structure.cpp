// Array lengths, index ranges and names: what every other pass takes for granted.
#include <algorithm>
#include <limits>
#include <unordered_set>

#include "host/common/parallel.hpp"
#include "host/quality/passes.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kStructureChunk = 65536;

std::string indexed(const char* what, std::size_t index, const char* holds, std::uint64_t value,
                    std::uint64_t limit) {
    return std::string(what) + " " + std::to_string(index) + ": " + holds + " " + std::to_string(value) +
           ", expected at most " + std::to_string(limit);
}

void expect_length(const char* array, std::size_t length, std::size_t expected, DefectLog& log) {
    if (length == expected) return;
    log.add(DefectKind::kArrayLength, [&] {
        return std::string(array) + ": " + std::to_string(length) + " values, expected " +
               std::to_string(expected);
    });
}

void check_lengths(const Mesh& mesh, DefectLog& log) {
    if (mesh.points.size() % 3 != 0) expect_length("points", mesh.points.size(), 3 * mesh.node_count(), log);
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        const std::size_t nodes = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        const std::string name = element_name(static_cast<ElementType>(t));
        expect_length((name + " nodes").c_str(), block.nodes.size(), nodes * block.size(), log);
        expect_length((name + " kind").c_str(), block.kind.size(), block.size(), log);
        const auto edges = static_cast<std::size_t>(kElementEdges[static_cast<std::size_t>(t)]);
        const std::size_t middles = mesh.is_second_order() ? edges * block.size() : 0;
        expect_length((name + " middles").c_str(), block.middles.size(), middles, log);
    }
    expect_length("facet middles", mesh.facets.middles.size(),
                  mesh.is_second_order() ? 4 * mesh.facets.size() : 0, log);
    expect_length("facet nodes", mesh.facets.nodes.size(), 4 * mesh.facets.size(), log);
    expect_length("facet inside", mesh.facets.inside.size(), mesh.facets.size(), log);
    expect_length("facet outside", mesh.facets.outside.size(), mesh.facets.size(), log);
    expect_length("hanging masters", mesh.hanging.masters.size(), 4 * mesh.hanging.size(), log);
    if (!mesh.model_dimension.empty())
        expect_length("model_dimension", mesh.model_dimension.size(), mesh.node_count(), log);
    // Facet matching counts elements and nodes in 32 bits and keeps the largest value for itself.
    constexpr std::uint64_t limit = std::numeric_limits<std::uint32_t>::max() - 1;
    if (mesh.element_count() > limit || mesh.node_count() > limit) {
        log.add(DefectKind::kArrayLength, [&] {
            return "mesh too large to check: " + std::to_string(mesh.element_count()) + " elements and " +
                   std::to_string(mesh.node_count()) + " nodes, expected at most " + std::to_string(limit);
        });
    }
}

/// Adds a defect for every value above `limit` or, with `from_one`, for zero.
template <class Value>
void check_range(const std::vector<Value>& values, std::uint64_t limit, bool from_one, DefectKind kind,
                 const char* what, const char* holds, std::size_t per_item, DefectLog& log) {
    std::vector<DefectLog> logs(chunk_count(values.size(), kStructureChunk));
    parallel_chunks(
        values.size(), kStructureChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (values[i] <= limit && !(from_one && values[i] == 0)) continue;
                logs[chunk].add(kind, [&] { return indexed(what, i / per_item, holds, values[i], limit); });
            }
        });
    for (const DefectLog& part : logs) log.merge(part);
}

/// A limit that no index meets stands for "none allowed": an empty range has no largest index.
template <class Value>
void check_index(const std::vector<Value>& values, std::size_t count, DefectKind kind, const char* what,
                 const char* holds, std::size_t per_item, DefectLog& log) {
    if (count > 0) {
        check_range(values, count - 1, false, kind, what, holds, per_item, log);
        return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        log.add(kind, [&] { return std::string(what) + " 0: there is nothing that it could refer to"; });
    }
}

}  // namespace

bool check_structure(const Mesh& mesh, DefectLog& log) {
    check_lengths(mesh, log);
    if (!log.empty()) return false;
    const std::size_t regions = mesh.region_names.size();
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        const char* name = element_name(static_cast<ElementType>(t));
        const std::size_t nodes = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        check_index(block.nodes, mesh.node_count(), DefectKind::kElementNodeRange, name, "node", nodes, log);
        const auto edges = static_cast<std::size_t>(kElementEdges[static_cast<std::size_t>(t)]);
        check_index(block.middles, mesh.node_count(), DefectKind::kElementNodeRange, name, "middle", edges,
                    log);
        check_range(block.region, regions, true, DefectKind::kElementRegion, name, "region", 1, log);
        constexpr std::uint64_t last_kind = static_cast<std::uint64_t>(ElementKind::kTransition);
        check_range(block.kind, last_kind, false, DefectKind::kElementKind, name, "kind", 1, log);
    }
    const FacetBlock& facets = mesh.facets;
    check_index(facets.nodes, mesh.node_count(), DefectKind::kFacetNodeRange, "facet", "node", 4, log);
    check_index(facets.middles, mesh.node_count(), DefectKind::kFacetNodeRange, "facet", "middle", 4, log);
    check_index(facets.surface, mesh.surface_names.size(), DefectKind::kFacetSurface, "facet", "surface", 1,
                log);
    check_range(facets.inside, regions, true, DefectKind::kFacetRegion, "facet", "inside region", 1, log);
    check_range(facets.outside, regions, false, DefectKind::kFacetRegion, "facet", "outside region", 1, log);
    check_index(mesh.hanging.node, mesh.node_count(), DefectKind::kHangingNode, "hanging node", "node", 1,
                log);
    check_index(mesh.hanging.masters, mesh.node_count(), DefectKind::kHangingNode, "hanging node", "master",
                4, log);
    std::unordered_set<std::string> names;
    for (const std::string& name : mesh.surface_names) {
        if (!names.insert(name).second) log.add(DefectKind::kSurfaceName, [&] { return "'" + name + "'"; });
    }
    return log.count(DefectKind::kElementNodeRange) == 0 && log.count(DefectKind::kFacetNodeRange) == 0 &&
           log.count(DefectKind::kHangingNode) == 0;
}

}  // namespace mortise::quality
