// Whether a cell's elements bear that its corners are moved.
#include "host/cnio/certificate.hpp"
#include "kernels/shared/leaf_template.h"

namespace mortise::cnio {
namespace {

/// Least quality (row_element_quality) of an element once its corners have moved: nodes that should be on one
/// plane may lie on both sides of it by their rounding.
constexpr double kLeastQuality = 1e-6;

}  // namespace

std::uint8_t Certificate::unfit_corners() const {
    const auto& nodes = cell_.nodes();
    const auto moves = [&](LocalNode node) { return nodes[node].target != nodes[node].point; };
    std::uint8_t snapped = 0;
    for (LocalNode c = 0; c < 8; ++c) snapped |= static_cast<std::uint8_t>(moves(c) ? 1u << c : 0u);
    if (cell_.is_misplaced()) return snapped;
    std::uint8_t unfit = 0;
    const auto position = [&](LocalNode node, double* p) {
        for (std::size_t j = 0; j < 3; ++j)
            p[j] = static_cast<double>(nodes[node].target[j]) / static_cast<double>(cell_.units());
    };
    const auto judge = [&](int type, const LocalNode* node, std::size_t count) {
        static constexpr int kOwn[8] = {0, 1, 2, 3, 4, 5, 6, 7};
        std::uint8_t blamed = 0;
        double p[8][3];
        for (std::size_t i = 0; i < count; ++i) {
            if (moves(node[i])) blamed |= node[i] < 8 ? static_cast<std::uint8_t>(1u << node[i]) : snapped;
            position(node[i], p[i]);
        }
        if (blamed != 0 && !(row_element_quality(p, type, kOwn) > kLeastQuality)) unfit |= blamed;
    };
    if (!whole_.empty()) {  // the cell as it is: leaves beside finer ones have no corners that snap
        double p[8][3];
        for (LocalNode c = 0; c < 8; ++c) position(c, p[c]);
        if (positive_hexahedra(p) == 0) unfit |= snapped;
    }
    for (std::size_t i = 0; i < pyramids_.size(); ++i) {
        if (pyramid_region_[i] > 0) judge(2, pyramids_[i].node.data(), 5);
    }
    for (std::size_t i = 0; i < simplices_.size(); ++i) {
        if (simplex_region_[i] > 0) judge(3, simplices_[i].node.data(), 4);
    }
    return unfit;
}

}  // namespace mortise::cnio
