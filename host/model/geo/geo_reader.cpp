// Reader of Netgen's .geo files: statements. Expressions: geo_expression.hpp.
//
// Source: Netgen's CSG parser. Differences: what Netgen skips with a message (unknown words between
// statements) is an error here, except a stray word before a statement or the end of the file, which is a
// warning; a solid that is defined twice is an error; statements that we cannot honour yet warn once per
// kind.
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "host/model/geo/geo_expression.hpp"
#include "host/model/readers.hpp"

namespace mortise::model_reader {
namespace {

class GeoReader {
  public:
    GeoReader(const std::string& text, const std::string& source)
        : text_(text), source_(source), lexer_(text, source), surfaces_(model_) {}

    Model read() {
        model_.source = source_;
        // Two nodes for each parenthesis and each operation, two of which most solids have: growing would
        // move them all again and again, and memory that is not used is not touched.
        const auto count = [this](char c) {
            return static_cast<std::size_t>(std::count(text_.begin(), text_.end(), c));
        };
        model_.nodes.reserve(std::min(2 * (count('(') + count('=')), text_.size() / 16) + 64);
        if (lexer_.at_end()) fail_here("the file is empty; expected 'algebraic3d'");
        if (!lexer_.take_word("algebraic3d")) {
            fail_here("expected 'algebraic3d' as the first word of a Netgen geometry, found " +
                      lexer_.found());
        }
        while (!lexer_.at_end()) read_statement();
        if (model_.regions.empty()) {
            fail_here("the file declares no top-level object; expected 'tlo NAME;' for at least one solid");
        }
        apply_overrides();
        apply_hints();
        return std::move(model_);
    }

  private:
    struct Override {
        std::uint32_t solid;
        std::uint32_t region;
        std::string name;
        std::string statement;
        SourceLocation where;
    };

    struct TopLevel {
        std::uint32_t node;
        std::uint32_t line;
    };

    struct Hint {
        SizeHint hint;
        std::string statement;
    };

    [[noreturn]] void fail_here(const std::string& message) const {
        fail(source_, lexer_.token().where, message);
    }

    void warn_once(const std::string& kind, SourceLocation where, const std::string& message) {
        if (warned_.insert(kind).second) model_.warnings.push_back(place_text(source_, where) + message);
    }

    void warn_unused(const std::string& statement, SourceLocation where) {
        warn_once(statement, where, "'" + statement + "' is read but not used yet");
    }

    void read_statement() {
        const SourceLocation where = lexer_.token().where;
        if (lexer_.take_word("solid")) return read_solid(where);
        if (lexer_.take_word("tlo")) return read_region(where);
        if (lexer_.take_word("boundingbox")) return read_bounding_box(where);
        if (lexer_.take_word("boundarycondition")) return read_override("boundarycondition", where);
        if (lexer_.take_word("boundaryconditionname")) return read_override("boundaryconditionname", where);
        if (lexer_.take_word("identify")) return read_identify(where);
        if (lexer_.take_word("singular")) return read_singular(where);
        if (lexer_.take_word("point")) return read_point(where);
        if (lexer_.take_word("define")) return read_define(where);
        if (lexer_.take_word("curve2d")) return read_curve(true);
        if (lexer_.take_word("curve3d")) return read_curve(false);
        read_stray_word(where);
    }

    /// Netgen prints and skips unknown words; one alone between statements does no harm.
    void read_stray_word(SourceLocation where) {
        const std::string word = lexer_.found();
        const std::string expected = "expected a statement (solid, tlo, boundingbox, ...), found " + word +
                                     nearest_hint(lexer_.token().text, geo_statement_names());
        if (lexer_.token().kind != GeoToken::Kind::kName) fail(source_, where, expected);
        lexer_.next();
        if (!lexer_.at_end() && !is_geo_statement(lexer_.token())) fail(source_, where, expected);
        model_.warnings.push_back(place_text(source_, where) + "the stray word " + word + " is ignored");
    }

    /// curve2d NAME = (n; points; m; pieces) ;  curve3d likewise
    void read_curve(bool in_plane) {
        const SourceLocation where = lexer_.token().where;
        const std::string name(lexer_.take_name("the name of a curve"));
        if (shapes_.curves.count(name) != 0) {
            fail(source_, where, "the curve '" + name + "' is defined twice; choose another name");
        }
        lexer_.take_symbol('=', "after the name of the curve");
        shapes_.curves.emplace(name, read_geo_curve(lexer_, in_plane));
        lexer_.take_symbol(';', "after the curve '" + name + "'");
    }

    /// solid NAME = expression [flags] ;
    void read_solid(SourceLocation where) {
        const std::string_view name = take_new_name();
        const auto first = static_cast<std::uint32_t>(model_.nodes.size());
        if (!lexer_.is_symbol('=')) lexer_.fail_expected("'=' after 'solid " + std::string(name) + "'");
        lexer_.next();
        std::uint32_t root = GeoExpression(model_, lexer_, surfaces_, solids_, shapes_, first).read();

        std::string condition;
        bool by_face = false;
        double max_size = 0;
        for (const GeoFlag& flag : lexer_.take_flags()) {
            if (flag.name == "maxh") {
                max_size = positive_flag(flag);
            } else if ((flag.name == "bc" || flag.name == "bcname") && flag.kind == GeoFlag::Kind::kList) {
                name_faces(root, flag);
                by_face = true;
            } else if (flag.name == "bcname") {
                condition = word_flag(flag);
            } else if (flag.name == "bc") {
                if (condition.empty()) condition = condition_number(number_flag(flag));
            } else {
                warn_of_flag(flag);
            }
        }
        if (!lexer_.is_symbol(';')) {
            lexer_.fail_expected("';' or a flag after the solid '" + std::string(name) + "'");
        }
        lexer_.next();

        if (!condition.empty() && !by_face) surfaces_.set_condition(root, condition);
        surfaces_.set_solid(first, std::string(name));
        if (max_size > 0) {
            // A solid that is only another one's name gets a node of its own to carry the size.
            if (root < first) root = model_.add_operation(CsgNode::Op::kUnion, {root});
            model_.nodes[root].max_size = max_size;
        }
        if (root >= first && model_.nodes[root].where.line == 0) model_.nodes[root].where = where;
        solids_.set(name, root);
    }

    /// -bc=[numbers] and -bcname=[words] of a polyhedron, one for each face.
    void name_faces(std::uint32_t root, const GeoFlag& flag) {
        const std::string name = "-" + std::string(flag.name) + "=[...]";
        const auto found = shapes_.faces.find(root);
        if (found == shapes_.faces.end()) {
            fail(source_, flag.where,
                 name + " names faces one by one; expected a solid that is one polyhedron, or a single name");
        }
        const std::size_t faces = found->second.back() + std::size_t{1};
        if (flag.list.size() != faces) {
            fail(source_, flag.where,
                 name + " has " + std::to_string(flag.list.size()) + " names; expected one for each of the " +
                     std::to_string(faces) + " faces");
        }
        surfaces_.set_face_conditions(root, found->second, flag.list, flag.name == "bc" ? "bc" : "");
    }

    std::string_view take_new_name() {
        const SourceLocation where = lexer_.token().where;
        const std::string_view name = lexer_.take_name("the name of a solid");
        if (is_geo_reserved(name))
            fail(source_, where,
                 "'" + std::string(name) + "' is a word of the language; choose another name");
        if (const NameTable::Entry* known = solids_.find(name)) {
            const auto line = 1 + std::count(text_.data(), known->name.data(), '\n');
            fail(source_, where,
                 "the solid '" + std::string(name) + "' is defined twice, first in line " +
                     std::to_string(line) + "; choose another name");
        }
        return name;
    }

    std::uint32_t take_solid(std::string_view what) {
        const SourceLocation where = lexer_.token().where;
        const std::string_view name = lexer_.take_name(what);
        const NameTable::Entry* found = solids_.find(name);
        if (found == nullptr) fail(source_, where, undefined_solid(std::string(name)));
        return found->value;
    }

    /// tlo NAME [flags] ;  or, for faces of a region,  tlo NAME SURFACE [flags] ;
    void read_region(SourceLocation where) {
        Region region;
        region.name = std::string(lexer_.token().text);
        region.root = take_solid("the name of a solid after 'tlo'");
        const bool is_surface = lexer_.token().kind == GeoToken::Kind::kName;
        const std::uint32_t surface = is_surface ? take_solid("the name of a solid") : 0;
        std::string material;
        for (const GeoFlag& flag : lexer_.take_flags()) {
            if (flag.name == "maxh") {
                region.max_size = positive_flag(flag);
            } else if (flag.name == "material") {
                material = word_flag(flag);
                if (is_surface) warn_of_flag(flag);
            } else {
                warn_of_flag(flag);
            }
        }
        if (!lexer_.is_symbol(';')) lexer_.fail_expected("';' or a flag after 'tlo " + region.name + "'");
        lexer_.next();
        if (is_surface) {
            // No region of its own: a size on the faces, or display only.
            if (region.max_size > 0 && !surfaces_.set_size(surface, region.root, region.max_size)) {
                model_.warnings.push_back(place_text(source_, where) + "'" + region.name +
                                          "' has no surface of that solid; its -maxh has no effect");
            }
            return;
        }
        region.metadata = std::string(lexer_.trailing_comment());
        if (!material.empty()) {
            region.metadata = "material=" + material + (region.metadata.empty() ? "" : " ") + region.metadata;
        }
        const auto [first, is_new] = region_of_.try_emplace(region.name, TopLevel{region.root, where.line});
        if (!is_new) {
            fail(source_, where,
                 "'tlo " + excerpt(region.name) + "' is given twice, first in line " +
                     std::to_string(first->second.line) + "; expected it once");
        }
        model_.regions.push_back(std::move(region));
    }

    /// boundingbox (lowest corner; highest corner) ;
    void read_bounding_box(SourceLocation where) {
        lexer_.take_symbol('(', "after 'boundingbox'");
        Box3 box;
        box.min = lexer_.take_vector("the first corner");
        lexer_.take_symbol(';', "between the corners");
        box.max = lexer_.take_vector("the second corner");
        lexer_.take_symbol(')', "after the corners");
        lexer_.take_symbol(';', "after 'boundingbox'");
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(box.min[k] < box.max[k])) {
                fail(source_, where,
                     "'boundingbox': the corners have the coordinates " + number_text(box.min[k]) + " and " +
                         number_text(box.max[k]) + "; expected the second to be larger");
            }
        }
        model_.clip = box;
    }

    /// boundarycondition SOLID REGION number ;  boundaryconditionname SOLID REGION name ;
    void read_override(const std::string& statement, SourceLocation where) {
        Override entry;
        entry.statement = statement;
        entry.where = where;
        entry.solid = take_solid("the name of a solid");
        const SourceLocation place = lexer_.token().where;
        const std::string region(lexer_.take_name("the name of a top-level object"));
        const auto found = region_of_.find(region);
        if (found == region_of_.end()) {
            fail(source_, place,
                 "'" + region + "' is not a top-level object yet; expected 'tlo " + region +
                     ";' above this line");
        }
        entry.region = found->second.node;
        entry.name = statement == "boundarycondition"
                         ? condition_number(lexer_.take_number("the number of the boundary condition"))
                         : std::string(lexer_.take_name("the name of the boundary condition"));
        lexer_.take_symbol(';', "after '" + statement + "'");
        overrides_.push_back(std::move(entry));
    }

    void apply_overrides() {
        for (const Override& entry : overrides_) {
            std::vector<std::uint32_t> others;
            for (const Region& region : model_.regions) {
                if (region.root != entry.region) others.push_back(region.root);
            }
            if (!surfaces_.override_condition(entry.solid, entry.region, others, entry.name)) {
                warn_once(entry.statement, entry.where,
                          "'" + entry.statement +
                              "' on a surface that also bounds another region is read but not used yet");
            }
        }
    }

    /// identify periodic A B ;  identify closesurfaces A B [flags] ;
    void read_identify(SourceLocation where) {
        const std::string kind(lexer_.take_name("'periodic' or 'closesurfaces'"));
        // Netgen has close edges inside, but no statement for them: it refuses them, too.
        if (kind != "periodic" && kind != "closesurfaces") {
            fail(source_, where, "'identify " + kind + "' is unknown; expected periodic or closesurfaces");
        }
        SizeHint hint;
        hint.kind = SizeHint::Kind::kGap;
        hint.where = where;
        std::string names;
        for (int k = 0; k < 2; ++k) {
            names += (k == 0 ? "" : " ") + std::string(lexer_.token().text);
            hint.groups.push_back(surfaces_.primitives(take_solid("the name of a solid")));
        }
        const std::vector<GeoFlag> flags = lexer_.take_flags();
        lexer_.take_symbol(';', "after 'identify'");
        for (const GeoFlag& flag : flags) warn_of_flag(flag);
        if (kind == "periodic") {
            model_.periodic.push_back({hint.groups[0], hint.groups[1], names, where});
            return;
        }
        hints_.push_back({std::move(hint), "identify closesurfaces"});
    }

    /// singular face REGION SOLID [flags] ;  singular edge A B [flags] ;  singular point A B C [flags] ;
    void read_singular(SourceLocation where) {
        const std::string kind(lexer_.take_name("'face', 'edge' or 'point'"));
        if (kind != "face" && kind != "edge" && kind != "point") {
            fail(source_, where, "'singular " + kind + "' is unknown; expected face, edge or point");
        }
        SizeHint hint;
        hint.kind = SizeHint::Kind::kMeeting;
        hint.where = where;
        std::vector<std::uint32_t> solids;
        for (int k = 0; k < (kind == "point" ? 3 : 2); ++k)
            solids.push_back(take_solid("the name of a solid"));
        if (kind == "face") {
            hint.groups = {surfaces_.common_primitives(solids[1], solids[0])};
        } else {
            for (const std::uint32_t solid : solids) hint.groups.push_back(surfaces_.primitives(solid));
        }
        hint.max_size = take_hint_size();
        lexer_.take_symbol(';', "after 'singular'");
        hints_.push_back({std::move(hint), "singular " + kind});
    }

    /// point (x, y, z) [flags] ;
    void read_point(SourceLocation where) {
        SizeHint hint;
        hint.where = where;
        lexer_.take_symbol('(', "after 'point'");
        hint.at = lexer_.take_vector("the point");
        lexer_.take_symbol(')', "after the point");
        hint.max_size = take_hint_size();
        lexer_.take_symbol(';', "after 'point'");
        model_.hints.push_back(std::move(hint));
    }

    /// Flags of a hint: -maxh is a size, -factor weighs basis functions and is of no use to a mesh.
    double take_hint_size() {
        double size = 0;
        for (const GeoFlag& flag : lexer_.take_flags()) {
            if (flag.name == "maxh") {
                size = positive_flag(flag);
            } else {
                warn_of_flag(flag);
            }
        }
        return size;
    }

    /// Keeps the hints whose solids bound a region; regions may be declared after them.
    void apply_hints() {
        if (hints_.empty()) return;
        std::vector<std::uint32_t> used;
        for (const Region& region : model_.regions) {
            const std::vector<std::uint32_t> below = surfaces_.primitives(region.root);
            used.insert(used.end(), below.begin(), below.end());
        }
        std::sort(used.begin(), used.end());
        for (Hint& entry : hints_) {
            bool whole = true;
            for (auto& group : entry.hint.groups) {
                group.erase(std::remove_if(group.begin(), group.end(),
                                           [&used](std::uint32_t node) {
                                               return !std::binary_search(used.begin(), used.end(), node);
                                           }),
                            group.end());
                whole = whole && !group.empty();
            }
            if (whole) {
                model_.hints.push_back(std::move(entry.hint));
            } else {
                warn_once(entry.statement, entry.hint.where,
                          "'" + entry.statement +
                              "' names a solid that has no surface on a top-level object; it has no effect");
            }
        }
    }

    /// define constant NAME = number [;]: Netgen itself does not take the semicolon.
    void read_define(SourceLocation where) {
        if (!lexer_.take_word("constant")) lexer_.fail_expected("'constant' after 'define'");
        lexer_.take_name("the name of a constant");
        lexer_.take_symbol('=', "after the constant's name");
        lexer_.take_number("the constant's value");
        if (lexer_.is_symbol(';')) lexer_.next();
        warn_unused("define constant", where);
    }

    double number_flag(const GeoFlag& flag) const {
        if (flag.kind != GeoFlag::Kind::kNumber) {
            fail(source_, flag.where, "expected a number: -" + std::string(flag.name) + "=number");
        }
        return flag.number;
    }

    double positive_flag(const GeoFlag& flag) const {
        const double value = number_flag(flag);
        if (!(value > 0)) {
            fail(source_, flag.where,
                 "-" + std::string(flag.name) + " is " + number_text(value) + "; expected a positive number");
        }
        return value;
    }

    std::string word_flag(const GeoFlag& flag) const {
        if (flag.kind == GeoFlag::Kind::kNumber) return number_text(flag.number);
        if (flag.kind != GeoFlag::Kind::kWord) {
            fail(source_, flag.where, "expected a name: -" + std::string(flag.name) + "=name");
        }
        return std::string(flag.word);
    }

    static std::string condition_number(double number) { return "bc_" + number_text(number); }

    /// Flags for display change nothing; others that we do not know are worth a line.
    void warn_of_flag(const GeoFlag& flag) {
        if (flag.name == "col" || flag.name == "transparent") return;
        const std::string name = "-" + excerpt(flag.name);
        warn_once(name, flag.where, "the flag '" + name + "' is read but not used");
    }

    const std::string& text_;
    const std::string& source_;
    Model model_;
    GeoLexer lexer_;
    GeoSurfaces surfaces_;
    GeoSolids solids_;
    GeoShapes shapes_;
    std::unordered_map<std::string, TopLevel> region_of_;  ///< by name
    std::unordered_set<std::string> warned_;
    std::vector<Override> overrides_;
    std::vector<Hint> hints_;
};

}  // namespace

Model read_geo(const std::string& text, const std::string& source) { return GeoReader(text, source).read(); }

}  // namespace mortise::model_reader
