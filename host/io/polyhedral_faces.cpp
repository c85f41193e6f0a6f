#include "host/io/polyhedral_faces.hpp"

#include <algorithm>
#include <string>

#include "host/common/face_key.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/common/periodic_originals.hpp"
#include "host/io/periodic_links.hpp"
#include "mortise/error.hpp"
#include "mortise/hanging.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kChunk = 16384;

/// Keys with what they stand for, to be found by key.
using KeyTable = std::vector<std::pair<FaceKey, std::uint32_t>>;

const std::uint32_t* find_key(const KeyTable& table, const FaceKey& key) {
    const auto found = std::lower_bound(table.begin(), table.end(), std::make_pair(key, std::uint32_t{0}));
    return found != table.end() && found->first == key ? &found->second : nullptr;
}

}  // namespace

struct PolyhedralFaces::Entry {
    FaceKey key;
    std::uint32_t cell;
    std::uint8_t local;

    bool operator<(const Entry& other) const {
        return key != other.key ? key < other.key : cell < other.cell;
    }
};

PolyhedralFaces::PolyhedralFaces(const Mesh& mesh, int threads) : mesh_(mesh) {
    for (std::size_t t = 0; t < kElementTypes; ++t) first_[t + 1] = first_[t] + mesh.elements[t].size();
    std::vector<Entry> entries;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const int count = local_faces(static_cast<ElementType>(t)).count;
        const std::size_t size = mesh.elements[t].size();
        std::vector<std::vector<Entry>> parts(chunk_count(size, kChunk));
        parallel_chunks(size, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                for (int f = 0; f < count; ++f) {
                    Entry entry;
                    entry.cell = static_cast<std::uint32_t>(first_[t] + i);
                    entry.local = static_cast<std::uint8_t>(f);
                    NodeId nodes[4];
                    entry.key = face_key(nodes, local_nodes(entry.cell, entry.local, nodes));
                    parts[begin / kChunk].push_back(entry);
                }
            }
        });
        append_lists(parts, threads, entries);
    }
    parallel_sort(entries, threads);
    match(entries);
}

std::size_t PolyhedralFaces::local_nodes(std::uint32_t cell, std::uint8_t local, NodeId* nodes) const {
    std::size_t type = 0;
    while (cell >= first_[type + 1]) ++type;
    const auto per_element = static_cast<std::size_t>(kElementNodes[type]);
    const NodeId* element = mesh_.elements[type].nodes.data() + per_element * (cell - first_[type]);
    std::size_t count = 0;
    for (const int k : local_faces(static_cast<ElementType>(type)).faces[local]) {
        if (k >= 0) nodes[count++] = element[k];
    }
    return count;
}

void PolyhedralFaces::match(std::vector<Entry>& entries) {
    std::vector<Entry> unmatched;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (i + 1 < entries.size() && entries[i].key == entries[i + 1].key) {
            faces_.push_back(
                {entries[i].cell, entries[i + 1].cell, entries[i].cell, entries[i].local, false});
            ++i;
        } else {
            unmatched.push_back(entries[i]);
        }
    }
    entries = {};
    if (mesh_.hanging.size() > 0) unmatched = add_hanging(unmatched);
    inner_count_ = faces_.size();
    parallel_sort(faces_, 0, [](const Face& a, const Face& b) {
        if (a.owner != b.owner) return a.owner < b.owner;
        if (a.neighbour != b.neighbour) return a.neighbour < b.neighbour;
        return a.cell != b.cell ? a.cell < b.cell : a.local < b.local;
    });
    add_outer(unmatched);
}

/// Faces between a larger cell and four others. Returns what is left.
std::vector<PolyhedralFaces::Entry> PolyhedralFaces::add_hanging(const std::vector<Entry>& unmatched) {
    const HangingNodes& hanging = mesh_.hanging;
    middles_ = EdgeMiddles(hanging);
    is_end_.assign(mesh_.node_count(), 0);
    for (std::size_t i = 0; i < hanging.size(); ++i) {
        if (hanging.in_edge(i)) is_end_[hanging.masters[4 * i]] = is_end_[hanging.masters[4 * i + 1]] = 1;
    }
    const std::vector<HangingFace> pairs = hanging_faces(hanging);
    KeyTable wholes, quarters;
    for (std::uint32_t i = 0; i < pairs.size(); ++i) {
        wholes.emplace_back(face_key(pairs[i].whole.data(), 4), i);
        for (const auto& quarter : pairs[i].quarters) quarters.emplace_back(face_key(quarter.data(), 4), i);
    }
    std::sort(wholes.begin(), wholes.end());
    std::sort(quarters.begin(), quarters.end());
    std::vector<std::uint32_t> larger(pairs.size(), kOutside);
    for (const Entry& entry : unmatched) {
        if (const std::uint32_t* pair = find_key(wholes, entry.key)) larger[*pair] = entry.cell;
    }
    std::vector<Entry> left;
    for (const Entry& entry : unmatched) {
        const std::uint32_t* pair = find_key(quarters, entry.key);
        if (pair != nullptr && larger[*pair] != kOutside) {
            const std::uint32_t other = larger[*pair];
            faces_.push_back({std::min(entry.cell, other), std::max(entry.cell, other), entry.cell,
                              entry.local, other < entry.cell});
        } else if (find_key(wholes, entry.key) == nullptr) {
            left.push_back(entry);
        }
    }
    return left;
}

void PolyhedralFaces::add_outer(const std::vector<Entry>& unmatched) {
    KeyTable surfaces;
    for (std::size_t i = 0; i < mesh_.facets.size(); ++i) {
        const FacetNodes nodes = mesh_.facets.facet(i);
        if (mesh_.facets.outside[i] == 0)
            surfaces.emplace_back(face_key(nodes.begin(), nodes.size()), mesh_.facets.surface[i]);
    }
    parallel_sort(surfaces, 0);
    std::vector<std::pair<std::uint32_t, Face>> outer;
    for (const Entry& entry : unmatched) {
        const std::uint32_t* surface = find_key(surfaces, entry.key);
        if (surface == nullptr) {
            throw Error(ExitCode::kMeshing, "cell " + std::to_string(entry.cell) +
                                                " has an outer face that is no facet of the mesh; see "
                                                "check_mesh");
        }
        outer.push_back({*surface, {entry.cell, kOutside, entry.cell, entry.local, false}});
    }
    std::sort(outer.begin(), outer.end(), [](const auto& a, const auto& b) {
        if (a.first != b.first) return a.first < b.first;
        return a.second.cell != b.second.cell ? a.second.cell < b.second.cell
                                              : a.second.local < b.second.local;
    });
    for (const auto& [surface, face] : outer) {
        if (patches_.empty() || patches_.back().surface != surface)
            patches_.push_back({surface, faces_.size(), 0});
        ++patches_.back().count;
        faces_.push_back(face);
    }
    if (!mesh_.periodic.empty()) pair_patches();
}

/// Faces of patches that are copies come in the order of their originals.
void PolyhedralFaces::pair_patches() {
    std::vector<std::uint32_t> patch_of_surface(mesh_.surface_names.size(), kNoGroup);
    for (std::size_t p = 0; p < patches_.size(); ++p)
        patch_of_surface[patches_[p].surface] = static_cast<std::uint32_t>(p);
    std::vector<std::uint32_t> patch_of(mesh_.facets.size(), kNoGroup);
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
        if (mesh_.facets.outside[f] == 0) patch_of[f] = patch_of_surface[mesh_.facets.surface[f]];
    }
    for (const PeriodicLink& link : periodic_links(mesh_, patch_of)) {
        Patch &copy = patches_[link.copy], &original = patches_[link.original];
        if (copy.partner != kNoPatch || original.partner != kNoPatch) continue;
        const std::vector<Face> ordered =
            images(original, copy, originals_of(mesh_.periodic[link.pair], mesh_.node_count()));
        if (ordered.size() != original.count) continue;
        copy.partner = link.original;
        original.partner = link.copy;
        std::copy(ordered.begin(), ordered.end(), faces_.begin() + static_cast<std::ptrdiff_t>(copy.first));
    }
}

/// The faces of a patch's copy, in the order of the patch and beginning at the same corners; fewer if there
/// are not as many.
std::vector<PolyhedralFaces::Face> PolyhedralFaces::images(const Patch& original, const Patch& copy,
                                                           const std::vector<NodeId>& original_of) const {
    KeyTable places;
    for (std::size_t i = 0; i < copy.count; ++i) {
        NodeId nodes[4];
        const Face& face = faces_[copy.first + i];
        const std::size_t count = local_nodes(face.cell, face.local, nodes);
        for (std::size_t k = 0; k < count; ++k) nodes[k] = original_of[nodes[k]];
        places.emplace_back(face_key(nodes, count), static_cast<std::uint32_t>(i));
    }
    std::sort(places.begin(), places.end());
    std::vector<Face> ordered;
    for (std::size_t i = 0; i < original.count; ++i) {
        NodeId nodes[4];
        const Face& face = faces_[original.first + i];
        const std::uint32_t* const found =
            find_key(places, face_key(nodes, local_nodes(face.cell, face.local, nodes)));
        if (found == nullptr) break;
        Face image = faces_[copy.first + *found];
        NodeId corners[4];
        const std::size_t count = local_nodes(image.cell, image.local, corners);
        while (image.start < count && original_of[corners[image.start]] != nodes[0]) ++image.start;
        if (image.start == count) break;
        ordered.push_back(image);
    }
    return ordered;
}

std::size_t PolyhedralFaces::corners(const Face& face, std::array<NodeId, kMostCorners>& corners) const {
    NodeId nodes[4];
    const std::size_t own = local_nodes(face.cell, face.local, nodes);
    if (face.reversed) std::reverse(nodes, nodes + own);
    std::rotate(nodes, nodes + face.start, nodes + own);
    std::size_t count = 0;
    for (std::size_t k = 0; k < own; ++k) {
        const NodeId next = nodes[(k + 1) % own];
        corners[count++] = nodes[k];
        if (is_end_.empty() || is_end_[nodes[k]] == 0 || is_end_[next] == 0) continue;
        if (const std::optional<NodeId> between = middles_.between(nodes[k], next))
            corners[count++] = *between;
    }
    return count;
}

}  // namespace mortise::io
