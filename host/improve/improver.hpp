// Passes over the blocks of a zone (docs/design/improvement.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "host/improve/improve.hpp"
#include "host/improve/loose_start.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// What a pass does to blocks: single changes, those of several steps, too, or slivers alone (Block::loosen).
enum class Effort { kPlain, kLookAhead, kLoosen };

/// What passes are for.
struct Aim {
    double target = kGoodQuality;  ///< quality that all elements are to have
    bool is_first = false;         ///< nothing has been improved yet
    /// If positive, elements of this quality, which are good enough, become better still: for that none
    /// become smaller, and no features are merged.
    double raised_from = 0;
};

class Improver {
  public:
    /// All are kept by reference, but for `aim`.
    Improver(Zone& zone, const Surfaces& surfaces, const Options& options, const Aim& aim)
        : zone_(zone), surfaces_(surfaces), options_(options), aim_(aim) {}

    /// Passes that let every node be inside a block once: their blocks are shifted, and in a graded tree pair
    /// elements with the next larger or the next smaller ones.
    int pass_count() const;

    /// The `number`-th of them.
    void pass(int number, Effort effort, Counters& counters);

    /// After everything else: later passes would put loose nodes back onto their surfaces.
    void loosen(Counters& counters);

    /// Whether so much is poor that the model itself must be the reason.
    bool is_hopeless() const;

    bool is_done() const;

  private:
    struct Group {
        std::vector<std::uint32_t> tetrahedra;
        std::vector<std::uint32_t> pyramids;
        bool poor = false;
        std::size_t poor_count = 0;  ///< tetrahedra
        bool lost = false;           ///< nearly all tetrahedra are poor
        bool crowded = false;  ///< most tetrahedra are in crowded cells: nothing would become good, in hours
    };

    /// The tetrahedra of a block: new, or as they are in the zone.
    struct Piece {
        bool is_new = false;
        const Tetrahedron* begin = nullptr;
        std::size_t count = 0;
    };

    /// An element counts as large as the largest of its nodes' leaves. So those around a node have, if it
    /// touches leaves of two sizes, these two.
    struct Place {
        Point sum = {0, 0, 0};  ///< of the corners
        int size_class = 0;
    };

    BlockOptions block_options(int number, Effort effort) const;
    std::vector<std::uint32_t> longest_first() const;
    std::vector<Block::Result> run_blocks(int number, Effort effort);
    void number_added(std::uint32_t group, const std::vector<Block::NewNode>& added,
                      std::vector<Tetrahedron>& tetrahedra);
    template <class Load>
    std::optional<Block::Result> run_block(Block& block, const Load& load, const BlockOptions& plain) const;
    template <class Load>
    std::optional<Block::Result> loosen_block(Block& block, const Load& load, BlockOptions options);
    double quality_of(const Pyramid& p) const;
    template <class Nodes>
    Place place_of(const Nodes& nodes) const;
    template <class Nodes>
    std::uint64_t block_of(const Nodes& nodes, int pairing, double shift) const;
    bool is_crowded(const std::vector<std::uint32_t>& tetrahedra) const;
    bool is_unplaced(const std::pair<ZoneNode, Point>& tip) const {
        return zone_.points[tip.first] != tip.second;
    }
    std::vector<Tetrahedron> join(const std::vector<Piece>& pieces);
    bool revert_clashes(const std::vector<Point>& before, std::vector<Tetrahedron>& all,
                        std::vector<BlockCounters>& counted);
    void group(int pairing, double shift, double least);
    void find_free_nodes();

    Zone& zone_;
    const Surfaces& surfaces_;
    const Options& options_;
    Aim aim_;
    LooseStart loose_start_;
    std::vector<Group> groups_;
    std::vector<std::size_t> first_;    ///< per group, and behind the last: its first tetrahedron after join
    std::vector<std::uint32_t> owner_;  ///< per node its group; kMixed: several; kNone: not used
    std::vector<std::uint8_t> free_;
};

}  // namespace mortise::improve
