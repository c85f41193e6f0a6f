// What half-planes, circles and whole trees of a profile become when it is swept.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/model/outlines/flat_tree.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Part of a solid under construction: constant, an intersection of half-spaces, or a node of the model.
struct Piece {
    enum class State : std::uint8_t { kNothing, kEverything, kPlanes, kNode };
    State state = State::kNothing;
    std::vector<Plane> planes{};
    std::uint32_t node = 0;
};

/// Builds the tree of a swept profile. What a half-plane and a circle become is up to the derived class.
class Sweep {
  public:
    Sweep(Model& model, std::string name, SourceLocation where)
        : model_(model), name_(std::move(name)), where_(where) {}
    virtual ~Sweep() = default;
    Sweep(const Sweep&) = delete;
    Sweep& operator=(const Sweep&) = delete;

    Piece sweep(const FlatTree& tree, std::uint32_t root);
    Piece combine(FlatNode::Op op, std::vector<Piece> pieces);
    std::uint32_t to_node(Piece piece);
    /// Whether nothing swept so far can reappear where its scale has gone through 0: convex loops cannot, for
    /// the constraints of opposite sides contradict each other there.
    bool ends_at_apex() const { return ends_at_apex_; }

  protected:
    /// normal·x <= offset; the larger component of `normal` is ±1.
    virtual Piece half_plane(const Vec2& normal, double offset, const std::string& side) = 0;
    /// The image of the circle of that radius about the origin.
    virtual Piece circle(const FlatMap& map, double radius, const std::string& side) = 0;
    /// The hull of discs in one piece, if it can be.
    virtual std::optional<Piece> rounded_outline(const std::vector<Disc>&) { return std::nullopt; }
    /// Puts loops in order before they are swept.
    virtual void adjust(Contours&) const {}
    /// A whole outline in one piece, if that is better than a formula of its edges.
    virtual std::optional<Piece> outline(const Contours&) { return std::nullopt; }

    Piece planes(std::vector<Plane> list, const std::string& side) const;
    Piece primitive(Primitive primitive, const std::string& side);
    /// A primitive that names its own sides, if there is one.
    std::optional<Piece> node_of(std::optional<Primitive> primitive);
    Piece expression(const std::string& formula, const std::string& side);
    Piece moved(const Affine& map, Piece piece);
    Piece complement(Piece piece);
    std::string next_side() { return "side" + std::to_string(++sides_); }

    Model& model_;
    std::string name_;
    SourceLocation where_;
    bool ends_at_apex_ = true;

  private:
    Piece loop(const std::vector<Vec2>& points, bool is_outer);
    Piece contours(Contours loops);

    int sides_ = 0;
};

/// The circle's image as { w : (w - centre)ᵀ form (w - centre) <= 1 }; `round`: it is a circle again, of
/// that radius.
struct Ellipse {
    Vec2 centre{};
    double xx = 0, xy = 0, yy = 0;  ///< of the form
    bool round = false;
    double radius = 0;
};
Ellipse ellipse_of(const FlatMap& map, double radius);

}  // namespace mortise::model_reader
