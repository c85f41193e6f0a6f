// Expressions of Netgen's .geo files: what stands between "solid NAME =" and the flags.
#pragma once

#include <string>
#include <vector>

#include "host/model/geo/geo_lexer.hpp"
#include "host/model/geo/geo_primitives.hpp"
#include "host/model/geo/geo_surfaces.hpp"
#include "host/model/name_table.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Solids defined so far: name -> node.
using GeoSolids = NameTable;

/// Whether a statement starts with this token.
bool is_geo_statement(const GeoToken& token);
/// The words that statements start with.
std::vector<std::string_view> geo_statement_names();
/// Whether `name` is a word of the language and cannot name a solid.
bool is_geo_reserved(std::string_view name);
/// Message for a name that is not in GeoSolids.
std::string undefined_solid(const std::string& name);

/// Solid = Term { or Term }; Term = Primary { and Primary }; Primary = primitive | NAME | ( Solid ) |
/// not Primary | translate (v; Solid) | rotate (c; a; Solid) | multitranslate (v; n; Solid) |
/// multirotate (c; a; n; Solid). Chains become one node with many children. No recursion: nesting depth is
/// limited by memory only.
class GeoExpression {
  public:
    /// Nodes from `first` on belong to this statement.
    GeoExpression(Model& model, GeoLexer& lexer, GeoSurfaces& surfaces, const GeoSolids& solids,
                  GeoShapes& shapes, std::uint32_t first)
        : model_(model),
          lexer_(lexer),
          surfaces_(surfaces),
          solids_(solids),
          shapes_(shapes),
          first_(first) {}

    std::uint32_t read();

  private:
    /// An open parenthesis, or the whole expression.
    struct Frame {
        SourceLocation where;
        bool in_parentheses = false;
        bool refers = false;           ///< an operand is, or contains, a solid of an earlier statement
        bool negated = false;          ///< an odd number of `not` precedes the next operand
        std::size_t first_term = 0;    ///< in terms_
        std::size_t first_factor = 0;  ///< in factors_
        bool is_copy = false;          ///< made by translate, ...: `maps` apply
        bool keeps_original = false;   ///< the operand itself belongs to the result too
        std::vector<Affine> maps;
    };

    /// Reads up to and with the next complete operand; opens frames on the way.
    std::uint32_t read_operand();
    void open_copy(std::string_view name);
    int take_count(std::string_view name);
    std::uint32_t close_term(const Frame& frame);
    std::uint32_t close_frame();
    std::uint32_t make_copies(const Frame& frame, std::uint32_t node);
    std::uint32_t combine(CsgNode::Op op, std::vector<std::uint32_t>& operands, std::size_t first);

    Model& model_;
    GeoLexer& lexer_;
    GeoSurfaces& surfaces_;
    const GeoSolids& solids_;
    GeoShapes& shapes_;
    std::uint32_t first_;
    std::vector<Frame> frames_;
    std::vector<std::uint32_t> terms_;
    std::vector<std::uint32_t> factors_;
};

}  // namespace mortise::model_reader
