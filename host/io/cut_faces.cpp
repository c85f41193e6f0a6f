#include "host/io/cut_faces.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "host/common/face_key.hpp"

namespace mortise::io {
namespace {

/// The eye sees from the right, front and above: what lies on these sides of the cut is taken away.
class Cut {
  public:
    Cut(const Mesh& mesh, const PictureCut& cut) : mesh_(mesh), axis_(static_cast<std::size_t>(cut.axis)) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (std::size_t i = axis_; i < mesh.points.size(); i += 3) {
            low = std::min(low, mesh.points[i]);
            high = std::max(high, mesh.points[i]);
        }
        at_ = cut.at.value_or(0.5 * (low + high));
    }

    bool takes(const NodeId* nodes, std::size_t count) const {
        double total = 0;
        for (std::size_t k = 0; k < count; ++k) total += mesh_.points[3 * std::size_t{nodes[k]} + axis_];
        const double centre = total / static_cast<double>(count);
        return axis_ == 1 ? centre < at_ : centre > at_;
    }

  private:
    const Mesh& mesh_;
    const std::size_t axis_;
    double at_ = 0;
};

/// Calls visit(type, nodes, count, block, index) for all elements.
template <class Visit>
void for_elements(const Mesh& mesh, const Visit& visit) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const auto count = static_cast<std::size_t>(kElementNodes[t]);
        for (std::size_t i = 0; i < block.size(); ++i)
            visit(static_cast<ElementType>(t), block.nodes.data() + count * i, count, block, i);
    }
}

}  // namespace

std::vector<DrawnFace> outer_faces(const Mesh& mesh) {
    std::vector<DrawnFace> faces;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.facets.outside[f] != 0) continue;
        DrawnFace face;
        std::copy_n(mesh.facets.nodes.data() + 4 * f, 4, face.node.begin());
        face.is_facet = true;
        face.surface = mesh.facets.surface[f];
        face.region = mesh.facets.inside[f];
        faces.push_back(face);
    }
    return faces;
}

std::vector<DrawnFace> faces_behind(const Mesh& mesh, const PictureCut& wanted) {
    const Cut cut(mesh, wanted);
    // A face that is seen has all its nodes on the boundary, or all at elements that are taken away.
    std::vector<std::uint8_t> on_boundary(mesh.node_count(), 0), at_taken(mesh.node_count(), 0);
    std::vector<std::pair<FaceKey, std::uint32_t>> outer;  // with their surfaces
    for (const DrawnFace& facet : outer_faces(mesh)) {
        for (const NodeId node : facet.node) on_boundary[node] = 1;
        outer.emplace_back(facet_key(facet.node), facet.surface);
    }
    std::sort(outer.begin(), outer.end());
    for_elements(mesh,
                 [&](ElementType, const NodeId* nodes, std::size_t count, const ElementBlock&, std::size_t) {
                     if (!cut.takes(nodes, count)) return;
                     for (std::size_t k = 0; k < count; ++k) at_taken[nodes[k]] = 1;
                 });
    std::vector<std::pair<FaceKey, DrawnFace>> faces;
    for_elements(mesh, [&](ElementType type, const NodeId* nodes, std::size_t count,
                           const ElementBlock& block, std::size_t i) {
        if (cut.takes(nodes, count)) return;
        const LocalFaces local = local_faces(type);
        for (int f = 0; f < local.count; ++f) {
            DrawnFace face;
            bool is_boundary = true, is_cut = true;
            for (std::size_t k = 0; k < 4; ++k) {
                const int corner = local.faces[f][k] >= 0 ? local.faces[f][k] : local.faces[f][2];
                face.node[k] = nodes[corner];
                is_boundary = is_boundary && on_boundary[face.node[k]] != 0;
                is_cut = is_cut && at_taken[face.node[k]] != 0;
            }
            if (!is_boundary && !is_cut) continue;
            face.region = block.region[i];
            face.kind = block.kind[i];
            faces.emplace_back(facet_key(face.node), face);
        }
    });
    std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<DrawnFace> seen;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        if (i + 1 < faces.size() && faces[i + 1].first == faces[i].first) {
            ++i;  // between two elements that stay
            continue;
        }
        DrawnFace face = faces[i].second;
        const auto facet =
            std::lower_bound(outer.begin(), outer.end(), std::make_pair(faces[i].first, std::uint32_t{0}));
        face.is_facet = facet != outer.end() && facet->first == faces[i].first;
        if (face.is_facet) face.surface = facet->second;
        seen.push_back(face);
    }
    return seen;
}

}  // namespace mortise::io
