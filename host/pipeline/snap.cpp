#include "host/pipeline/snap.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "host/common/parallel.hpp"
#include "host/octree/odd_corner.hpp"
#include "host/snapping/snapping.hpp"

namespace mortise::pipeline {
namespace {

using octree::SnappedVertex;

constexpr std::size_t kSnapChunk = 64;

/// Corners of a face, as a set.
u32 corners_of_face(int f) {
    u32 corners = 0;
    for (const u8 c : kFaceCorners[f]) corners |= 1u << c;
    return corners;
}

}  // namespace

Snapping::Snapping(snio::Classifier& classifier, Prepared& prepared, bool keep, int threads)
    : classifier_(classifier), prepared_(prepared), tree_(prepared.tree), keep_(keep), threads_(threads) {}

std::size_t Snapping::find(std::vector<std::uint32_t> strict) {
    const std::vector<std::uint32_t> complex = find_complex();
    tree_.crowded = cnio::find_crowded(prepared_.bound, tree_, complex, threads_);
    for (const std::uint64_t code : tree_.crowded) strict.push_back(tree_.nio_index(code));
    for (const octree::LeafJoint& joint : tree_.joints) strict.push_back(tree_.nio_index(joint.morton));
    std::sort(strict.begin(), strict.end());
    vertices_ = snapping::find_snapped(prepared_.bound, tree_, complex, strict, threads_);
    snaps_.assign(vertices_.size(), 1);
    list_touched();
    std::vector<std::uint32_t> dirty(touched_.size());
    std::iota(dirty.begin(), dirty.end(), 0u);
    while (!dirty.empty()) dirty = take_back(find_unfit(dirty));
    return tree_.snapped.size();
}

/// Leaves that are complex while no vertex has moved, or may be.
std::vector<std::uint32_t> Snapping::find_complex() {
    const std::vector<SnioCandidate>& candidates = classifier_.candidates();
    std::vector<std::uint32_t> complex;
    for (std::uint32_t i = 0; i < candidates.size(); ++i) {
        if ((candidates[i].flags & kCandidateSimple) == 0 || candidates[i].needed != 0) complex.push_back(i);
    }
    return complex;
}

void Snapping::list_touched() {
    struct Entry {
        Leaf leaf;
        u32 corner;
        std::uint32_t vertex;
    };
    std::vector<Entry> entries;
    const Tree tree = tree_.view();
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
        const std::uint64_t code = vertices_[v].code;
        for (u32 d = 0; d < 8; ++d) {
            const Leaf leaf =
                leaf_at_vertex(&tree, gather_bits(code), gather_bits(code >> 1), gather_bits(code >> 2), d);
            if (leaf.kind != kLeafNone) entries.push_back({leaf, 7 - d, v});
        }
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return a.leaf.code != b.leaf.code ? a.leaf.code < b.leaf.code : a.corner < b.corner;
    });
    for (const Entry& entry : entries) {
        if (touched_.empty() || touched_.back().leaf.morton != entry.leaf.code) {
            Touched touched{};
            touched.is_in = entry.leaf.kind == kLeafIn;
            touched.corners.leaf = entry.leaf.index;
            touched.corners.surface = kNoCandidateSurface;
            if (touched.is_in) {
                touched.leaf.morton = entry.leaf.code;
                touched.corners.region = octree::in_region(tree_, entry.leaf.code);
                touched.is_complex = is_misfit(entry.leaf.code);
            } else {
                touched.leaf = tree_.nio[entry.leaf.index];
                const SnioCandidate& candidate = classifier_.candidates()[entry.leaf.index];
                touched.is_complex = (candidate.flags & kCandidateSimple) == 0;
            }
            touched_.push_back(touched);
        }
        touched_.back().vertex[entry.corner] = entry.vertex;
        touched_.back().corners.snapped |= static_cast<u8>(1u << entry.corner);
    }
    extraction_.records.resize(touched_.size());
}

/// Whether an IN leaf will not fit the leaves beyond its faces, where formulas hold in one cell each.
bool Snapping::is_misfit(std::uint64_t code) const {
    if (prepared_.bound.polyhedra.empty()) return false;
    const Tree tree = tree_.view();
    for (int f = 0; f < 6; ++f) {
        const Leaf beyond = leaf_beyond(&tree, code, tree_.level_of(code), f);
        if (beyond.kind == kLeafNone) return true;
        if (beyond.kind != kLeafNio) continue;
        if (sides_agree(corners_of_face(f), 0, classifier_.candidates()[beyond.index], f) == 0) return true;
    }
    return false;
}

/// A leaf's corners by the vertices that still snap.
void Snapping::update(Touched& touched) const {
    SnappedLeaf& corners = touched.corners;
    corners.zero = 0;
    for (u32 rest = corners.snapped; rest != 0; rest &= rest - 1) {
        const u32 c = mortise_lowest_bit(rest);
        const u8 bit = static_cast<u8>(1u << c);
        const SnappedVertex& vertex = vertices_[touched.vertex[c]];
        if (snaps_[touched.vertex[c]] == 0) {
            corners.snapped &= static_cast<u8>(~bit);
            continue;
        }
        std::copy(vertex.moved.begin(), vertex.moved.end(), corners.moved[c]);
        if (touched.is_in || touched.is_complex) continue;
        if (vertex.is_on(classifier_.candidates()[corners.leaf].surface)) corners.zero |= bit;
    }
    touched.is_split = false;
    for (int f = 0; f < 6 && !touched.is_split; ++f)
        touched.is_split = octree::odd_corner(tree_, prepared_.bound, touched.leaf.morton, f) < 4;
}

/// Finds out what becomes of simple leaves, places in touched_.
void Snapping::judge_simple(const std::vector<std::uint32_t>& simple) {
    if (simple.empty()) return;
    std::vector<SnappedLeaf> corners;
    for (const std::uint32_t i : simple) corners.push_back(touched_[i].corners);
    const std::vector<SnioCandidate> found = classifier_.with_corners(corners);
    parallel_chunks(simple.size(), kSnapChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) {
            Touched& touched = touched_[simple[k]];
            touched.keeps = has_face_on_other(touched)
                                ? snio::Keeps::kNothing
                                : snio::keeps_template(prepared_.bound, tree_, found[k], corners[k]);
        }
    });
}

/// Vertices to take back since one of these leaves does not bear them, some of them more than once. Leaves
/// that may or may not keep a template must bear both.
std::vector<std::uint32_t> Snapping::find_unfit(const std::vector<std::uint32_t>& dirty) {
    tree_.snapped.clear();
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        if (snaps_[v] != 0) tree_.snapped.push_back(vertices_[v]);
    }
    std::vector<std::uint32_t> simple;
    std::vector<cnio::CellToMesh> cells;
    for (const std::uint32_t i : dirty) {
        update(touched_[i]);
        if (!touched_[i].is_in && !touched_[i].is_complex) simple.push_back(i);
    }
    judge_simple(simple);
    for (const std::uint32_t i : dirty) {
        if (touched_[i].needs_certificate()) cells.push_back({touched_[i].leaf, i});
    }
    cnio::extract_again(prepared_.bound, tree_, cells, prepared_.apexes, threads_, extraction_);
    if (!keep_) extraction_.arenas.clear();
    std::vector<Blame> blames;
    for (const std::uint32_t i : dirty) {
        Touched& touched = touched_[i];
        const u32 snapped = touched.corners.snapped;
        if (touched.needs_certificate()) {
            const cnio::CellRecord& record = extraction_.records[i];
            const bool is_lost = record.unresolved + record.limited > 0;
            blames.push_back({i, is_lost ? snapped : record.unfit, is_lost});
        } else if (touched.is_in && (!find_surface(touched) || !snio::stays_hexahedron(touched.corners))) {
            blames.push_back({i, snapped, true});
        }
    }
    return choose(blames);
}

/// Of what a leaf blames one vertex, unless it needs all: the others may do without. The one that most leaves
/// blame, so that few go; else on the fewest surfaces, which others are more likely to reach; else that moves
/// farthest.
std::vector<std::uint32_t> Snapping::choose(const std::vector<Blame>& blames) const {
    std::vector<std::uint32_t> times(vertices_.size(), 0);
    for (const Blame& blame : blames) {
        for (u32 rest = blame.corners; rest != 0; rest &= rest - 1)
            ++times[touched_[blame.leaf].vertex[mortise_lowest_bit(rest)]];
    }
    const auto weight = [&](std::uint32_t v) {
        const SnappedVertex& vertex = vertices_[v];
        std::int64_t way = 0;
        for (const std::int64_t x : vertex.moved) way += x * x;
        return std::make_tuple(times[v], -int{vertex.surface_count}, way);
    };
    std::vector<std::uint32_t> chosen;
    std::vector<std::uint32_t> blamed;
    for (const Blame& blame : blames) {
        blamed.clear();
        for (u32 rest = blame.corners; rest != 0; rest &= rest - 1)
            blamed.push_back(touched_[blame.leaf].vertex[mortise_lowest_bit(rest)]);
        if (!blame.needs_all && blamed.size() > 1) {
            std::swap(blamed[0], *std::max_element(blamed.begin(), blamed.end(),
                                                   [&](auto a, auto b) { return weight(a) < weight(b); }));
            blamed.resize(1);
        }
        chosen.insert(chosen.end(), blamed.begin(), blamed.end());
    }
    return chosen;
}

/// The simple leaf beyond a face all of whose corners snap; else null.
const SnioCandidate* Snapping::simple_beyond(const Touched& touched, int f) const {
    const u32 corners = corners_of_face(f);
    if ((touched.corners.snapped & corners) != corners) return nullptr;
    const Tree tree = tree_.view();
    const std::uint64_t code = touched.leaf.morton;
    const Leaf beyond = leaf_beyond(&tree, code, tree_.level_of(code), f);
    if (beyond.kind != kLeafNio) return nullptr;
    const SnioCandidate& candidate = classifier_.candidates()[beyond.index];
    return (candidate.flags & kCandidateSimple) != 0 ? &candidate : nullptr;
}

/// Whether a face of a simple leaf may lie on a surface that is not the leaf's: templates list no facets
/// there.
bool Snapping::has_face_on_other(const Touched& touched) const {
    for (int f = 0; f < 6; ++f) {
        const SnioCandidate* beyond = simple_beyond(touched, f);
        if (beyond != nullptr && beyond->surface != classifier_.candidates()[touched.corners.leaf].surface)
            return true;
    }
    return false;
}

/// The surface that a face of an IN leaf may lie on; false if faces lie on different ones.
bool Snapping::find_surface(Touched& touched) const {
    std::uint32_t& surface = touched.corners.surface;
    surface = kNoCandidateSurface;
    for (int f = 0; f < 6; ++f) {
        const SnioCandidate* beyond = simple_beyond(touched, f);
        if (beyond == nullptr) continue;
        if (surface != kNoCandidateSurface && surface != beyond->surface) return false;
        surface = beyond->surface;
    }
    return true;
}

/// These vertices stay where they are; the leaves around them, ascending.
std::vector<std::uint32_t> Snapping::take_back(const std::vector<std::uint32_t>& unfit) {
    for (const std::uint32_t v : unfit) snaps_[v] = 0;
    std::vector<std::uint32_t> dirty;
    for (std::uint32_t i = 0; i < touched_.size() && !unfit.empty(); ++i) {
        bool changes = false;
        for (u32 rest = touched_[i].corners.snapped; rest != 0 && !changes; rest &= rest - 1)
            changes = snaps_[touched_[i].vertex[mortise_lowest_bit(rest)]] == 0;
        if (changes) dirty.push_back(i);
    }
    return dirty;
}

void Snapping::classify() {
    std::vector<SnappedLeaf> simple;
    std::vector<snio::SnappedInLeaf> in_leaves;
    std::vector<std::uint32_t> complex;
    for (const Touched& touched : touched_) {
        if (touched.is_complex && !touched.is_in) continue;
        if (!touched.is_in && (touched.is_split || touched.keeps == snio::Keeps::kNothing)) {
            complex.push_back(touched.corners.leaf);
        } else if (touched.corners.snapped != 0 && touched.is_in) {
            in_leaves.push_back(
                {touched.leaf.morton, touched.corners, touched.is_split || touched.is_complex});
        } else if (touched.corners.snapped != 0) {
            simple.push_back(touched.corners);
        }
    }
    prepared_.classification = classifier_.finish(simple, in_leaves, complex);
}

void Snapping::extract() {
    if (!keep_) return;
    cnio::Extraction& result = prepared_.extraction;
    result.leaves = prepared_.classification.cnio;
    result.records.resize(result.leaves.size());
    result.arenas = std::move(extraction_.arenas);
    std::vector<cnio::CellToMesh> missing;
    auto known = touched_.begin();
    for (std::uint32_t i = 0; i < result.leaves.size(); ++i) {
        const TreeNode& leaf = tree_.nio[result.leaves[i]];
        while (known != touched_.end() && known->leaf.morton < leaf.morton) ++known;
        if (known != touched_.end() && known->leaf.morton == leaf.morton && known->needs_certificate()) {
            result.records[i] = extraction_.records[static_cast<std::size_t>(known - touched_.begin())];
        } else {
            missing.push_back({leaf, i});
        }
    }
    cnio::extract_again(prepared_.bound, tree_, missing, prepared_.apexes, threads_, result);
}

}  // namespace mortise::pipeline
