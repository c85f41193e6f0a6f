#include "host/snio/classify.hpp"

#include <numeric>
#include <utility>

#include "host/snio/face_plans.hpp"

namespace mortise::snio {

using device::Buffer;
using device::Device;

Classifier::Classifier(Device& device, octree::Octree& tree, octree::DeviceTree& on_device, bool templates,
                       bool snap, const std::vector<std::uint32_t>& complex)
    : device_(device),
      tree_(tree),
      on_device_(on_device),
      templates_(templates),
      snap_(templates && snap ? 1 : 0) {
    if (!templates_ && !on_device_.local_formulas) return;
    candidates_ = device_.allocate(count() * sizeof(SnioCandidate));
    launch("snio/classify.cl", "classify", count(), on_device_.nio, on_device_.tapes, on_device_.surfaces,
           on_device_.ops, candidates_, snap_);
    leave_to_certificate(complex);
    // Now, as complex leaves are about to snap vertices, which makes no leaf a misfit that was none.
    if (on_device_.local_formulas) drop_misfits();
}

const std::vector<SnioCandidate>& Classifier::candidates() {
    if (first_.empty()) first_ = device_.download<SnioCandidate>(candidates_, count());
    return first_;
}

std::vector<SnioCandidate> Classifier::with_corners(const std::vector<SnappedLeaf>& leaves) {
    const Buffer snapped = device_.upload(leaves);
    const Buffer candidates = device_.allocate(leaves.size() * sizeof(SnioCandidate));
    launch("snio/classify.cl", "classify_snapped", leaves.size(), on_device_.nio, on_device_.tapes,
           on_device_.surfaces, on_device_.ops, snapped, candidates);
    return device_.download<SnioCandidate>(candidates, leaves.size());
}

Classification Classifier::finish(const std::vector<SnappedLeaf>& simple,
                                  const std::vector<SnappedInLeaf>& in_leaves,
                                  const std::vector<std::uint32_t>& complex) {
    if (!templates_ && !on_device_.local_formulas) return all_complex();
    std::vector<SnappedLeaf> snapped = simple;
    std::vector<std::uint64_t> codes;
    for (const SnappedLeaf& leaf : simple) codes.push_back(tree_.nio[leaf.leaf].morton);
    if (!simple.empty()) {
        const std::vector<SnioCandidate> found = with_corners(simple);
        for (std::size_t i = 0; i < simple.size(); ++i) first_[simple[i].leaf] = found[i];
        device_.upload(candidates_, first_.data(), first_.size());
    }
    leave_to_certificate(complex);
    find_points();
    if (on_device_.local_formulas) drop_misfits();
    if (snap_ != 0 || on_device_.local_formulas) {
        promote(in_leaves);
    } else {
        std::vector<std::uint32_t> places(count());
        std::iota(places.begin(), places.end(), 0u);
        point_of_ = device_.upload(places);
        promoted_points_ = device_.allocate(0);
    }
    if (!templates_) return all_complex();
    if (on_device_.local_formulas) drop_misfits();  // promoted leaves, too
    for (std::size_t i = 0; i < simple.size(); ++i) snapped[i].leaf = tree_.nio_index(codes[i]);
    std::vector<std::uint32_t> promoted;
    for (const SnappedInLeaf& leaf : in_leaves) {
        const std::uint32_t index = tree_.nio_index(leaf.code);
        if (leaf.is_complex) {
            promoted.push_back(index);
        } else {
            snapped.push_back(leaf.corners);
            snapped.back().leaf = index;
        }
    }
    leave_to_certificate(promoted);
    if (!snapped.empty()) snap_corners(snapped);
    plans_ = device_.allocate(sizeof(FacePlans));
    device_.upload(plans_, &face_plans(), 1);
    vetoes_ = no_vetoes();
    launch("snio/snap.cl", "test_subsets", rows(kLeavesInChunk), on_device_.nio, points_, promoted_points_,
           point_of_, candidates_, plans_, vetoes_, snap_, static_cast<std::uint32_t>(count()));
    launch("snio/snap.cl", "veto_needs", count(), on_device_.nio, candidates_, vetoes_);
    Classification result = fill();
    for (std::uint32_t i = 0; i < count(); ++i) {
        if (result.leaves[i].pattern == kPatternCnio) result.cnio.push_back(i);
    }
    return result;
}

/// Work-items of kernels that handle so many leaves each on a CPU, and one on others.
std::size_t Classifier::rows(std::size_t leaves) const {
    if (device_.lanes() != 8) return count();
    return (count() + leaves - 1) / leaves;
}

/// vetoes_of of kernels/shared/snio.h, for all leaves.
Buffer Classifier::no_vetoes() {
    Buffer vetoes = device_.allocate((count() + 3) / 4 * sizeof(std::uint32_t));
    device_.fill_zero(vetoes);
    return vetoes;
}

template <class... Arguments>
void Classifier::launch(const char* file, const char* entry, std::size_t items,
                        const Arguments&... arguments) {
    octree::launch_on(device_, on_device_, device_.kernel(file, entry), items, arguments...);
}

void Classifier::leave_to_certificate(const std::vector<std::uint32_t>& leaves) {
    if (leaves.empty()) return;
    const Buffer buffer = device_.upload(leaves);
    device_.launch(device_.kernel("snio/classify.cl", "leave_to_certificate"), leaves.size(), buffer,
                   candidates_);
}

void Classifier::find_points() {
    points_ = device_.allocate(count() * sizeof(SnioPoints));
    const Buffer near = device_.allocate(count() * sizeof(std::uint8_t));
    launch("snio/points.cl", "find_points", rows(kLeavesInRow), on_device_.nio, on_device_.surfaces,
           on_device_.ops, candidates_, points_, near, snap_, static_cast<std::uint32_t>(count()));
    if (!on_device_.has_formulas) return;
    launch("snio/share_points.cl", "share_points", count(), on_device_.nio, on_device_.surfaces, candidates_,
           points_, near, snap_);
}

/// Leaves that do not fit their neighbours go to the certificate.
void Classifier::drop_misfits() {
    Buffer misfit = device_.allocate(count() * sizeof(std::uint8_t));
    launch("snio/misfits.cl", "find_misfits", count(), on_device_.nio, on_device_.tapes, candidates_, misfit);
    device_.launch(device_.kernel("snio/misfits.cl", "drop_misfits"), count(), misfit, candidates_);
}

/// IN leaves with a corner on the surface, or snapped before, join the NIO leaves, here and on the device.
void Classifier::promote(const std::vector<SnappedInLeaf>& in_leaves) {
    const std::size_t words = tree_.words();
    const std::size_t bytes = words * sizeof(std::uint32_t);
    const Buffer vetoes = no_vetoes();
    Buffer promoted = device_.allocate(bytes);
    if (in_leaves.empty()) {
        device_.fill_zero(promoted);
    } else {
        std::vector<std::uint32_t> bits(words, 0);
        for (const SnappedInLeaf& leaf : in_leaves) bits[tree_.at(leaf.code).word] |= 1u << (leaf.code & 31);
        device_.upload(promoted, bits.data(), words);
    }
    launch("snio/snap.cl", "mark_vertices", count(), on_device_.nio, candidates_, vetoes, promoted);
    if (on_device_.local_formulas) launch("snio/misfits.cl", "mark_exposed", words, promoted);
    Buffer in_bits = device_.allocate(bytes);
    Buffer nio_bits = device_.allocate(bytes);
    Buffer in_rank;
    Buffer nio_rank;
    device_.launch(device_.kernel("snio/snap.cl", "promote_words"), words, on_device_.in_bits,
                   on_device_.nio_bits, promoted, in_bits, nio_bits);
    tree_.in_count = octree::make_rank(device_, in_bits, words, in_rank);
    const std::uint64_t all = octree::make_rank(device_, nio_bits, words, nio_rank);
    Buffer nio = device_.allocate(all * sizeof(TreeNode));
    Buffer candidates = device_.allocate(all * sizeof(SnioCandidate));
    point_of_ = device_.allocate(all * sizeof(std::uint32_t));
    promoted_points_ = device_.allocate((all - count()) * sizeof(SnioPoints));
    launch("snio/snap.cl", "promote_leaves", words, nio_bits, nio_rank, on_device_.nio, candidates_, points_,
           vetoes, nio, candidates, point_of_, promoted_points_);
    device_.finish();
    on_device_.nio = std::move(nio);
    on_device_.in_bits = std::move(in_bits);
    on_device_.nio_bits = std::move(nio_bits);
    on_device_.in_rank = std::move(in_rank);
    on_device_.nio_rank = std::move(nio_rank);
    candidates_ = std::move(candidates);
    tree_.nio = device_.download<TreeNode>(on_device_.nio, all);
    tree_.in_bits = device_.download<std::uint32_t>(on_device_.in_bits, words);
    tree_.nio_bits = device_.download<std::uint32_t>(on_device_.nio_bits, words);
    tree_.in_rank = device_.download<std::uint32_t>(on_device_.in_rank, words + 1);
    tree_.nio_rank = device_.download<std::uint32_t>(on_device_.nio_rank, words + 1);
}

void Classifier::snap_corners(const std::vector<SnappedLeaf>& leaves) {
    const Buffer snapped = device_.upload(leaves);
    device_.launch(device_.kernel("snio/snap.cl", "snap_corners_of"), leaves.size(), snapped, point_of_,
                   candidates_, points_, promoted_points_);
}

/// Every leaf is left to the certificate.
Classification Classifier::all_complex() const {
    Classification result;
    SnioLeaf leaf{};
    leaf.pattern = kPatternCnio;
    result.leaves.assign(count(), leaf);
    result.used.assign(count(), 0);
    result.facets.assign(count(), 0);
    for (auto& elements : result.elements) elements.assign(count(), 0);
    result.cnio.resize(count());
    std::iota(result.cnio.begin(), result.cnio.end(), 0u);
    return result;
}

Classification Classifier::fill() {
    Classification result;
    const auto make = [&](auto& values) {
        values.resize(count());
        return device_.wrap(values.data(), values.size() * sizeof(values[0]));
    };
    Buffer leaves = make(result.leaves);
    Buffer used = make(result.used);
    Buffer facets = make(result.facets);
    Buffer counts = device_.allocate(kElementTypes * count() * sizeof(std::uint32_t));
    launch("snio/fill.cl", "fill", rows(kLeavesInChunk), on_device_.nio, candidates_, vetoes_, points_,
           promoted_points_, point_of_, plans_, leaves, used, counts, facets,
           static_cast<std::uint32_t>(count()), snap_);
    for (Buffer* buffer : {&leaves, &used, &facets}) device_.sync_to_host(*buffer);
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        result.elements[t] = device_.download<std::uint32_t>(counts, count(), t * count());
    }
    return result;
}

Classification classify(Device& device, octree::Octree& tree, octree::DeviceTree& on_device, bool templates,
                        bool snap, const std::vector<std::uint32_t>& complex) {
    return Classifier(device, tree, on_device, templates, snap, complex).finish({}, {}, {});
}

}  // namespace mortise::snio
