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

/// What the values of an array are, for messages.
struct Meaning {
    DefectKind kind;
    const char* what;          ///< whose they are
    const char* holds;         ///< what each is
    std::size_t per_item = 1;  ///< values
};

/// Adds a defect for each value that is out of range.
class Ranges {
  public:
    Ranges(int threads, DefectLog& log) : threads_(threads), log_(log) {}

    /// Values from `least`, 0 or 1, to `most`.
    template <class Value>
    void check(const std::vector<Value>& values, std::uint64_t least, std::uint64_t most,
               const Meaning& meaning) {
        std::vector<DefectLog> logs(chunk_count(values.size(), kStructureChunk));
        parallel_numbered(values.size(), kStructureChunk, threads_,
                          [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                              for (std::size_t i = begin; i < end; ++i) {
                                  if (values[i] >= least && values[i] <= most) continue;
                                  logs[chunk].add(meaning.kind, [&] {
                                      return indexed(meaning.what, i / meaning.per_item, meaning.holds,
                                                     values[i], most);
                                  });
                              }
                          });
        for (const DefectLog& part : logs) log_.merge(part);
    }

    /// Indices of an array of `count` values, which may be none.
    template <class Value>
    void check_index(const std::vector<Value>& values, std::size_t count, const Meaning& meaning) {
        if (count > 0) return check(values, 0, count - 1, meaning);
        for (std::size_t i = 0; i < values.size(); ++i) {
            log_.add(meaning.kind, [&] {
                return std::string(meaning.what) + " 0: there is nothing that it could refer to";
            });
        }
    }

  private:
    const int threads_;
    DefectLog& log_;
};

}  // namespace

bool check_structure(const Mesh& mesh, int threads, DefectLog& log) {
    check_lengths(mesh, log);
    if (!log.empty()) return false;
    Ranges ranges(threads, log);
    const std::size_t nodes = mesh.node_count(), regions = mesh.region_names.size();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const char* name = element_name(static_cast<ElementType>(t));
        const auto corners = static_cast<std::size_t>(kElementNodes[t]);
        const auto edges = static_cast<std::size_t>(kElementEdges[t]);
        ranges.check_index(block.nodes, nodes, {DefectKind::kElementNodeRange, name, "node", corners});
        ranges.check_index(block.middles, nodes, {DefectKind::kElementNodeRange, name, "middle", edges});
        ranges.check(block.region, 1, regions, {DefectKind::kElementRegion, name, "region"});
        constexpr auto last_kind = static_cast<std::uint64_t>(ElementKind::kLayer);
        ranges.check(block.kind, 0, last_kind, {DefectKind::kElementKind, name, "kind"});
    }
    const FacetBlock& facets = mesh.facets;
    ranges.check_index(facets.nodes, nodes, {DefectKind::kFacetNodeRange, "facet", "node", 4});
    ranges.check_index(facets.middles, nodes, {DefectKind::kFacetNodeRange, "facet", "middle", 4});
    ranges.check_index(facets.surface, mesh.surface_names.size(),
                       {DefectKind::kFacetSurface, "facet", "surface"});
    ranges.check(facets.inside, 1, regions, {DefectKind::kFacetRegion, "facet", "inside region"});
    ranges.check(facets.outside, 0, regions, {DefectKind::kFacetRegion, "facet", "outside region"});
    ranges.check_index(mesh.hanging.node, nodes, {DefectKind::kHangingNode, "hanging node", "node"});
    ranges.check_index(mesh.hanging.masters, nodes, {DefectKind::kHangingNode, "hanging node", "master", 4});
    std::unordered_set<std::string> names;
    for (const std::string& name : mesh.surface_names) {
        if (!names.insert(name).second) log.add(DefectKind::kSurfaceName, [&] { return "'" + name + "'"; });
    }
    return log.count(DefectKind::kElementNodeRange) == 0 && log.count(DefectKind::kFacetNodeRange) == 0 &&
           log.count(DefectKind::kHangingNode) == 0;
}

}  // namespace mortise::quality
