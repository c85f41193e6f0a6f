// text() of .csg: see text_outlines.hpp. Outlines are taken in font units, without hinting.
#include "host/model/outlines/text_outlines.hpp"

#include <fontconfig/fontconfig.h>
#include <hb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <stdexcept>

#include "host/common/words.hpp"
#include "host/model/outlines/outline_pieces.hpp"

namespace mortise::model_reader {
namespace {

constexpr const char* kDefaultFont = "Liberation Sans";
/// Size of a text by the height of its em square, in OpenSCAD.
constexpr double kSizeOfEm = 0.72;

template <typename T, void (*kDestroy)(T*)>
struct Destroy {
    void operator()(T* object) const { kDestroy(object); }
};
template <typename T, void (*kDestroy)(T*)>
using Owned = std::unique_ptr<T, Destroy<T, kDestroy>>;

using Pattern = Owned<FcPattern, FcPatternDestroy>;
using Blob = Owned<hb_blob_t, hb_blob_destroy>;
using Face = Owned<hb_face_t, hb_face_destroy>;
using Font = Owned<hb_font_t, hb_font_destroy>;
using Buffer = Owned<hb_buffer_t, hb_buffer_destroy>;
using DrawFunctions = Owned<hb_draw_funcs_t, hb_draw_funcs_destroy>;

const FcChar8* as_fontconfig(const std::string& text) {
    return reinterpret_cast<const FcChar8*>(text.c_str());
}

std::string as_string(const FcChar8* text) { return reinterpret_cast<const char*>(text); }

struct FontFile {
    std::string path;
    int index = 0;
    std::string family;
};

/// fontconfig's best match; warns if it belongs to another family than the one asked for. Without a path,
/// and with a warning, where the name cannot be read: OpenSCAD draws nothing then.
FontFile find_font(const std::string& wanted, std::vector<std::string>& warnings) {
    const std::size_t colon = wanted.find(':');
    std::string family = wanted.substr(0, colon);
    if (family.empty()) family = kDefaultFont;
    // A '-' would start a size in fontconfig's notation.
    std::string name;
    for (const char c : family) {
        if (c == '-' || c == ',' || c == '\\') name += '\\';
        name += c;
    }
    if (colon != std::string::npos) name += wanted.substr(colon);

    const Pattern pattern(FcNameParse(as_fontconfig(name)));
    if (!pattern) {
        warnings.push_back("the font '" + excerpt(wanted) +
                           "' is not of the form Name or Name:style=Bold; its texts are left out");
        return {};
    }
    // Only outlines can be extruded.
    FcPatternAddBool(pattern.get(), FC_SCALABLE, FcTrue);
    FcConfigSubstitute(nullptr, pattern.get(), FcMatchPattern);
    FcDefaultSubstitute(pattern.get());
    FcResult result = FcResultNoMatch;
    const Pattern match(FcFontMatch(nullptr, pattern.get(), &result));
    FcChar8* path = nullptr;
    if (!match || FcPatternGetString(match.get(), FC_FILE, 0, &path) != FcResultMatch) {
        throw std::invalid_argument("no font is installed; install " + std::string(kDefaultFont) +
                                    " (Debian: fonts-liberation)");
    }
    FontFile font;
    font.path = as_string(path);
    FcPatternGetInteger(match.get(), FC_INDEX, 0, &font.index);
    bool found = false;
    FcChar8* text = nullptr;
    for (int i = 0; FcPatternGetString(match.get(), FC_FAMILY, i, &text) == FcResultMatch; ++i) {
        if (i == 0) font.family = as_string(text);
        found = found || FcStrCmpIgnoreCase(text, as_fontconfig(family)) == 0;
    }
    if (!found) {
        warnings.push_back("the font '" + excerpt(family) + "' is not installed; '" + font.family +
                           "' is used instead");
    }
    return font;
}

/// Collects the loops of one glyph; curves become `segments` straight pieces.
struct GlyphOutline {
    Contours loops;
    int segments = 2;

    void start(double x, double y) { loops.push_back({{x, y}}); }
    void line_to(double x, double y) { loops.back().push_back({x, y}); }
    void curve_to(const std::array<Vec2, 4>& p) {
        for (int i = 1; i <= segments; ++i) {
            const double t = static_cast<double>(i) / segments;
            const double s = 1 - t;
            Vec2 point{};
            for (std::size_t k = 0; k < 2; ++k) {
                point[k] = s * s * s * p[0][k] + 3 * s * s * t * p[1][k] + 3 * s * t * t * p[2][k] +
                           t * t * t * p[3][k];
            }
            line_to(i < segments ? point[0] : p[3][0], i < segments ? point[1] : p[3][1]);
        }
    }
};

GlyphOutline& outline_of(void* data) { return *static_cast<GlyphOutline*>(data); }

void move_to(hb_draw_funcs_t*, void* data, hb_draw_state_t*, float x, float y, void*) {
    outline_of(data).start(x, y);
}

void line_to(hb_draw_funcs_t*, void* data, hb_draw_state_t*, float x, float y, void*) {
    outline_of(data).line_to(x, y);
}

void quadratic_to(hb_draw_funcs_t*, void* data, hb_draw_state_t* state, float cx, float cy, float x, float y,
                  void*) {
    const Vec2 from = {state->current_x, state->current_y};
    const Vec2 control = {cx, cy};
    const Vec2 to = {x, y};
    std::array<Vec2, 4> cubic = {from, from, to, to};
    for (std::size_t k = 0; k < 2; ++k) {
        cubic[1][k] = (from[k] + 2 * control[k]) / 3;
        cubic[2][k] = (to[k] + 2 * control[k]) / 3;
    }
    outline_of(data).curve_to(cubic);
}

void cubic_to(hb_draw_funcs_t*, void* data, hb_draw_state_t* state, float ax, float ay, float bx, float by,
              float x, float y, void*) {
    outline_of(data).curve_to(
        {Vec2{state->current_x, state->current_y}, Vec2{ax, ay}, Vec2{bx, by}, Vec2{x, y}});
}

void close_path(hb_draw_funcs_t*, void*, hb_draw_state_t*, void*) {}

DrawFunctions make_draw_functions() {
    DrawFunctions functions(hb_draw_funcs_create());
    hb_draw_funcs_set_move_to_func(functions.get(), move_to, nullptr, nullptr);
    hb_draw_funcs_set_line_to_func(functions.get(), line_to, nullptr, nullptr);
    hb_draw_funcs_set_quadratic_to_func(functions.get(), quadratic_to, nullptr, nullptr);
    hb_draw_funcs_set_cubic_to_func(functions.get(), cubic_to, nullptr, nullptr);
    hb_draw_funcs_set_close_path_func(functions.get(), close_path, nullptr, nullptr);
    return functions;
}

void set_properties(hb_buffer_t* buffer, const TextStyle& style) {
    if (!style.direction.empty()) {
        const hb_direction_t direction = hb_direction_from_string(style.direction.c_str(), -1);
        if (direction == HB_DIRECTION_INVALID) {
            throw std::invalid_argument("direction is '" + excerpt(style.direction) +
                                        "'; expected ltr, rtl, ttb or btt");
        }
        hb_buffer_set_direction(buffer, direction);
    }
    if (!style.script.empty()) {
        // Names that do not start like their codes.
        std::string code = style.script;
        if (code == "latin") code = "Latn";
        if (code == "greek") code = "Grek";
        if (code == "cyrillic") code = "Cyrl";
        const hb_script_t script = hb_script_from_string(code.c_str(), -1);
        if (script != HB_SCRIPT_UNKNOWN && script != HB_SCRIPT_INVALID) hb_buffer_set_script(buffer, script);
    }
    if (!style.language.empty()) {
        hb_buffer_set_language(buffer, hb_language_from_string(style.language.c_str(), -1));
    }
    hb_buffer_guess_segment_properties(buffer);
}

std::size_t choice(const char* what, const std::string& value, const std::vector<std::string>& known) {
    std::string list;
    for (std::size_t i = 0; i < known.size(); ++i) {
        if (known[i] == value) return i;
        list += (i == 0 ? "" : i + 1 < known.size() ? ", " : " or ") + known[i];
    }
    throw std::invalid_argument(std::string(what) + " is '" + excerpt(value) + "'; expected " + list);
}

/// Moves all pieces so that the text stands where halign and valign say. `end`: the sum of the advances.
void align(std::vector<Contours>& pieces, const TextStyle& style, const Vec2& end) {
    const double halign =
        0.5 * static_cast<double>(choice("halign", style.halign, {"left", "center", "right"}));
    const std::size_t valign = choice("valign", style.valign, {"baseline", "bottom", "center", "top"});
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Contours& piece : pieces) {
        for (const auto& loop : piece) {
            for (const Vec2& point : loop) {
                low = std::min(low, point[1]);
                high = std::max(high, point[1]);
            }
        }
    }
    if (!(low <= high)) return;
    Vec2 shift = {-halign * end[0], 0};
    if (valign != 0) shift[1] = -(low + 0.5 * static_cast<double>(valign - 1) * (high - low));
    for (Contours& piece : pieces) {
        for (auto& loop : piece) {
            for (Vec2& point : loop) point = {point[0] + shift[0], point[1] + shift[1]};
        }
    }
}

}  // namespace

int text_segments(double size, double fn, double fa, double fs) {
    return std::max(fragments_of(size, fn, fa, fs) / 8 + 1, 2);
}

std::vector<Contours> text_outlines(const TextStyle& style, std::vector<std::string>& warnings) {
    if (!(style.size > 0) || !std::isfinite(style.size)) {
        throw std::invalid_argument("size is not a positive, finite number");
    }
    if (!std::isfinite(style.spacing)) throw std::invalid_argument("spacing is not a finite number");
    if (style.text.empty()) return {};
    if (style.text.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
        throw std::invalid_argument("the text is too long");
    }
    const FontFile file = find_font(style.font, warnings);
    if (file.path.empty()) return {};
    const Blob blob(hb_blob_create_from_file(file.path.c_str()));
    const Face face(hb_face_create(blob.get(), static_cast<unsigned>(file.index) & 0xffffU));
    if (hb_face_get_glyph_count(face.get()) == 0) {
        throw std::invalid_argument("the font file " + file.path + " cannot be read");
    }
    const Font font(hb_font_create(face.get()));
    const double unit = style.size / kSizeOfEm / hb_face_get_upem(face.get());

    const Buffer buffer(hb_buffer_create());
    const int length = static_cast<int>(style.text.size());
    hb_buffer_add_utf8(buffer.get(), style.text.data(), length, 0, length);
    set_properties(buffer.get(), style);
    hb_shape(font.get(), buffer.get(), nullptr, 0);

    const DrawFunctions functions = make_draw_functions();
    unsigned count = 0;
    const hb_glyph_info_t* infos = hb_buffer_get_glyph_infos(buffer.get(), &count);
    const hb_glyph_position_t* positions = hb_buffer_get_glyph_positions(buffer.get(), &count);
    std::vector<Contours> pieces;
    Vec2 pen{};
    std::size_t missing = 0;
    for (unsigned i = 0; i < count; ++i) {
        if (infos[i].codepoint == 0) ++missing;
        GlyphOutline outline;
        outline.segments = std::max(style.segments, 1);
#if HB_VERSION_ATLEAST(7, 0, 0)
        hb_font_draw_glyph(font.get(), infos[i].codepoint, functions.get(), &outline);
#else
        hb_font_get_glyph_shape(font.get(), infos[i].codepoint, functions.get(), &outline);
#endif
        for (auto& loop : outline.loops) {
            for (Vec2& point : loop) {
                point = {pen[0] + unit * (point[0] + positions[i].x_offset),
                         pen[1] + unit * (point[1] + positions[i].y_offset)};
            }
        }
        add_winding_pieces(std::move(outline.loops), pieces);
        pen[0] += unit * positions[i].x_advance * style.spacing;
        pen[1] += unit * positions[i].y_advance * style.spacing;
    }
    if (missing != 0) {
        warnings.push_back("the font '" + file.family + "' lacks " + std::to_string(missing) +
                           " of the characters of '" + style.text + "'");
    }
    align(pieces, style, pen);
    return pieces;
}

}  // namespace mortise::model_reader
