#include <algorithm>
#include <numeric>

#include "host/improve/block.hpp"
#include "host/improve/clash.hpp"

namespace mortise::improve {
namespace {

/// Bits of a node's number in the key of a face.
constexpr int kNodeBits = 21;

/// The three nodes of a face, ascending, in one number.
using FaceKey = std::uint64_t;
constexpr FaceKey kNoFace = ~FaceKey{0};

struct CheckedFace {
    FaceKey node = kNoFace;
    FaceTag tag = 0;
    std::uint16_t region = 0;
    bool even = false;  ///< outward order is an even permutation of the key's
    bool paired = false;
};

/// Faces without a partner and facets on one side only: what the block shows to others.
struct Border {
    FaceKey node;
    FaceTag tag;
    bool even;

    bool operator<(const Border& other) const {
        return node != other.node ? node < other.node : even < other.even;
    }
    bool operator==(const Border& other) const {
        return node == other.node && even == other.even && tag == other.tag;
    }
};

/// Faces by their nodes: open addressing, at most half full.
class FaceTable {
  public:
    explicit FaceTable(std::size_t faces) {
        while ((std::size_t{1} << bits_) < 2 * faces) ++bits_;
        table_.resize(std::size_t{1} << bits_);
    }
    CheckedFace& at(FaceKey node) {
        // Fibonacci hashing.
        std::size_t i = static_cast<std::size_t>((node * 0x9e3779b97f4a7c15u) >> (64 - bits_));
        while (table_[i].node != kNoFace && table_[i].node != node) i = (i + 1) & (table_.size() - 1);
        return table_[i];
    }
    const std::vector<CheckedFace>& all() const { return table_; }

  private:
    int bits_ = 4;
    std::vector<CheckedFace> table_;
};

bool is_pair(const CheckedFace& a, const CheckedFace& b) {
    if (a.paired || a.even == b.even || (a.tag == 0) != (b.tag == 0)) return false;
    const bool interface = a.tag != 0;
    if (interface != (a.region != b.region)) return false;
    return !interface || (a.tag ^ b.tag) == kTagInside;
}

FaceKey key_of(const std::array<std::uint64_t, 3>& ascending) {
    return (ascending[0] << (2 * kNodeBits)) | (ascending[1] << kNodeBits) | ascending[2];
}

/// The faces of some tetrahedra, paired.
class Faces {
  public:
    explicit Faces(std::size_t tetrahedra) : table_(4 * tetrahedra) {}

    /// False if a face occurs where it must not.
    bool add(const Tetrahedron& t) {
        for (std::size_t f = 0; f < 4; ++f) {
            std::array<std::uint64_t, 3> n = nodes_of(t, f);
            const bool even = sort_three(n);
            const CheckedFace face{key_of(n), t.tag[f], t.region, even, false};
            CheckedFace& known = table_.at(face.node);
            if (known.node == kNoFace) {
                known = face;
            } else if (is_pair(known, face)) {
                known.paired = true;
            } else {
                return false;
            }
        }
        return true;
    }

    /// Whether a tetrahedron that is not among these has a face of theirs that nobody else may have.
    bool intrudes(const Tetrahedron& t) {
        for (std::size_t f = 0; f < 4; ++f) {
            std::array<std::uint64_t, 3> n = nodes_of(t, f);
            sort_three(n);
            const CheckedFace& known = table_.at(key_of(n));
            if (known.node != kNoFace && !is_border(known)) return true;
        }
        return false;
    }

    std::vector<Border> border() const {
        std::vector<Border> result;
        for (const CheckedFace& face : table_.all()) {
            if (face.node != kNoFace && is_border(face)) result.push_back({face.node, face.tag, face.even});
        }
        std::sort(result.begin(), result.end());
        return result;
    }

  private:
    static std::array<std::uint64_t, 3> nodes_of(const Tetrahedron& t, std::size_t face) {
        const auto& o = kOpposite[face];
        return {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
    }
    /// Facets of the outer boundary may change; everything else is shared with others.
    static bool is_border(const CheckedFace& face) {
        return !face.paired && (face.tag == 0 || (face.tag & kTagInterface) != 0);
    }

    FaceTable table_;
};

bool is_same(const Tetrahedron& a, const Tetrahedron& b) {
    return a.node == b.node && a.tag == b.tag && a.region == b.region;
}

}  // namespace

/// Whether the tetrahedra that have come show others the same faces as those that have gone.
bool Block::verify_faces() const {
    std::vector<std::uint32_t> gone, come, stayed;
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        if (i < original_.size() && alive_[i] != 0 && is_same(original_[i], tetrahedra_[i])) {
            stayed.push_back(i);
            continue;
        }
        if (i < original_.size()) gone.push_back(i);
        if (alive_[i] != 0) come.push_back(i);
    }
    Faces before(gone.size()), after(come.size());
    std::vector<std::uint8_t> has_come(points_.size(), 0);
    for (const std::uint32_t i : gone) {
        if (!before.add(original_[i])) return false;
    }
    for (const std::uint32_t i : come) {
        if (!after.add(tetrahedra_[i])) return false;
        for (const Local n : tetrahedra_[i].node) has_come[n] = 1;
    }
    if (before.border() != after.border()) return false;
    return std::none_of(stayed.begin(), stayed.end(), [&](std::uint32_t i) {
        const auto& n = tetrahedra_[i].node;
        return has_come[n[0]] + has_come[n[1]] + has_come[n[2]] + has_come[n[3]] > 2 &&
               after.intrudes(tetrahedra_[i]);
    });
}

bool Block::verify() const {
    if (points_.size() >> kNodeBits != 0) return false;  // the keys would not fit
    if (!verify_faces()) return false;
    const double same = kSameNode * unit_;
    std::vector<Local> order;
    for (Local n = 0; n < points_.size(); ++n) {
        if (!star_[n].empty() || !pyramid_star_[n].empty()) order.push_back(n);
    }
    std::sort(order.begin(), order.end(), [&](Local a, Local b) { return points_[a] < points_[b]; });
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (std::size_t j = i + 1; j < order.size(); ++j) {
            const Point d = points_[order[j]] - points_[order[i]];
            if (d[0] > same) break;
            if (squared_length(d) < same * same) return false;
        }
    }
    return true;
}

}  // namespace mortise::improve
