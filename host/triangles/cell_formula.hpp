// The formula of a polyhedron in one cell: a tape over the planes of the triangles that touch the cell.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"
#include "host/triangles/polygon.hpp"
#include "host/triangles/winding.hpp"

namespace mortise::triangles {

class CellFormula {
  public:
    CellFormula(const tape::BoundModel& model, const WindingNumber& winding)
        : model_(model), winding_(winding) {}

    /// Makes the formula for polygons (at least one), the triangles' parts in a cell of the given size.
    ///
    /// Of planes alone: by binary space partition. A polygon's plane halves the cell, each half has its own
    /// formula. What lies beside the last polygon of a half is found by winding number, so that open or
    /// overlapping surfaces do. With patches: by a decision tree over the signs of the surfaces at samples,
    /// both sides of each polygon and all sides of creases and corners among them.
    void make(const std::vector<Polygon>& polygons, const glm::dvec3& centre, double cell_size);

    bool is_constant() const { return root_ <= kTrue; }
    bool value() const { return root_ == kTrue; }
    /// Postfix words; their deepest stack.
    const std::vector<std::uint32_t>& words() const { return words_; }
    int stack() const { return is_constant() ? 0 : terms_[root_].need; }

  private:
    static constexpr std::uint32_t kFalse = 0;
    static constexpr std::uint32_t kTrue = 1;
    struct Term {
        std::uint32_t word = 0;  ///< a literal, or the operation of its two children
        std::uint32_t first = 0;
        std::uint32_t second = 0;
        int need = 0;  ///< stack entries
    };

    /// A point, and what is known of it.
    struct Sample {
        glm::dvec3 at{};
        std::vector<bool> behind;  ///< per surface of surfaces_: f < 0
        bool solid = false;
        double weight = 0;  ///< of its polygon: its area
        int side = 0;       ///< of its polygon: -1 behind it, 1 before it; 0 if it belongs to none
    };

    std::uint32_t divide(std::vector<Polygon> polygons);
    std::vector<Sample> take_samples(const std::vector<Polygon>& polygons, const glm::dvec3& centre) const;
    template <class Add>
    void sample_creases(const std::vector<Polygon>& polygons, const Add& add) const;
    void find_solid(std::vector<Sample>& samples) const;
    std::uint32_t decide(const std::vector<Sample>& samples);
    std::uint32_t combine(std::uint32_t surface, std::uint32_t inner, std::uint32_t outer);
    std::uint32_t choose_plane(const std::vector<Polygon>& polygons) const;
    bool is_solid_beside(const std::vector<Polygon>& polygons, std::uint32_t surface, int side) const;
    std::uint32_t add_literal(std::uint32_t surface, bool negated);
    std::uint32_t add_operation(std::uint32_t operation, std::uint32_t a, std::uint32_t b);
    std::uint32_t add_term(const Term& term);
    CutPlane plane(std::uint32_t surface) const;
    SurfaceSample sample(std::uint32_t surface, const glm::dvec3& x) const;
    bool is_on(std::uint32_t surface, const glm::dvec3& x, double near) const;
    void emit(std::uint32_t term);

    const tape::BoundModel& model_;
    const WindingNumber& winding_;
    double cell_size_ = 1;
    double tolerance_ = 0;
    std::vector<std::uint32_t> surfaces_;  ///< of the polygons, ascending
    std::vector<Term> terms_;
    std::uint32_t root_ = kFalse;
    std::vector<std::uint32_t> words_;
};

}  // namespace mortise::triangles
