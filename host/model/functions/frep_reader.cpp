// Reader of libfive's archives (.frep): binary, little-endian. Each shape is 'T' "name" "documentation", then
// operations - a byte, and a float for a constant, or the numbers of the arguments (the right one first),
// which count operations from the file's start - then 0xFF, variables, 0xFF; or 't' with the number of an
// operation.
//
// The operations' numbers depend on how libfive was built (LIBFIVE_PACKED_OPCODES, libfive/tree/opcode.hpp)
// and the file does not tell. Where both tables can be read to the end, the one whose file adds, multiplies
// or takes minima is meant.
#include <array>
#include <cstring>
#include <optional>
#include <string_view>

#include "host/model/functions/function_model.hpp"
#include "host/model/readers.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

enum class Meaning : std::uint8_t {
    kUnknown,
    kConstant,
    kX,
    kY,
    kZ,
    kSame,
    kSquare,
    kSqrt,
    kNegate,
    kSin,
    kCos,
    kTan,
    kAsin,
    kAcos,
    kAtan,
    kExp,
    kAbs,
    kLog,
    kReciprocal,
    kAdd,
    kMultiply,
    kMin,
    kMax,
    kSubtract,
    kDivide,
    kAtan2,
    kPower,
    kRoot,
    kMod,
    kCompare
};

using Table = std::array<Meaning, 32>;

constexpr Table make_table(bool packed) {
    using M = Meaning;
    Table table{};
    constexpr M kCommon[] = {M::kUnknown, M::kConstant, M::kX,    M::kY,      M::kZ,   M::kUnknown,
                             M::kSame,    M::kSquare,   M::kSqrt, M::kNegate, M::kSin, M::kCos,
                             M::kTan,     M::kAsin,     M::kAcos, M::kAtan,   M::kExp};
    constexpr M kBinary[] = {M::kAdd,   M::kMultiply, M::kMin,  M::kMax, M::kSubtract, M::kDivide,
                             M::kAtan2, M::kPower,    M::kRoot, M::kMod, M::kUnknown};
    std::size_t at = 0;
    for (const M meaning : kCommon) table[at++] = meaning;
    if (packed) {
        for (const M meaning : {M::kAbs, M::kLog, M::kReciprocal}) table[at++] = meaning;
        for (const M meaning : kBinary) table[at++] = meaning;
    } else {
        for (const M meaning : kBinary) table[at++] = meaning;
        for (const M meaning : {M::kAbs, M::kReciprocal, M::kLog}) table[at++] = meaning;
    }
    table[31] = M::kCompare;
    return table;
}

constexpr Table kStandardTable = make_table(false);
constexpr Table kPackedTable = make_table(true);
constexpr std::uint8_t kEnd = 0xff;

struct Shape {
    std::string name;
    std::size_t root = 0;
};

class FrepReader {
  public:
    FrepReader(const std::string& bytes, const Table& table) : bytes_(bytes), table_(table) {}

    /// False: the bytes make no sense with this table; `problem` tells.
    bool read() {
        while (at_ < bytes_.size() && problem.empty()) read_shape();
        if (shapes.empty() && problem.empty()) stop("the file holds no shape");
        return problem.empty();
    }

    FunctionText function;
    std::vector<Shape> shapes;
    std::vector<bool> has_z;  ///< per operation
    bool is_usual = false;    ///< adds, multiplies or takes a minimum
    std::string problem;

  private:
    bool stop(const std::string& message) {
        if (problem.empty()) problem = "byte " + std::to_string(at_ + 1) + ": " + message;
        return false;
    }

    template <class T>
    bool take(T& value) {
        if (bytes_.size() - at_ < sizeof value) return stop("the file ends too early");
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return true;
    }

    bool take_text(std::string& text) {
        if (at_ >= bytes_.size() || bytes_[at_] != '"') return stop("expected a name in quotes");
        for (++at_; at_ < bytes_.size(); ++at_) {
            if (bytes_[at_] == '"') {
                ++at_;
                return true;
            }
            if (bytes_[at_] == '\\' && at_ + 1 < bytes_.size()) ++at_;
            text += bytes_[at_];
        }
        return stop("the file ends inside a name");
    }

    bool take_argument(std::size_t& place) {
        std::uint32_t number = 0;
        if (!take(number)) return false;
        if (number >= function.size())
            return stop("operation " + std::to_string(number) + " is used before it is there");
        place = number;
        return true;
    }

    void read_shape() {
        const char tag = bytes_[at_];
        if (tag != 'T' && tag != 't') {
            stop("expected 'T', the start of a shape (is this a libfive archive?)");
            return;
        }
        ++at_;
        Shape shape;
        std::string documentation;
        if (!take_text(shape.name) || !take_text(documentation)) return;
        if (tag == 't') {
            if (!take_argument(shape.root)) return;
        } else {
            const std::size_t first = function.size();
            std::uint8_t code = 0;
            while (take(code) && code != kEnd) {
                if (!read_operation(code)) return;
            }
            if (!problem.empty()) return;
            if (function.size() == first && function.size() == 0) {
                stop("the shape has no operation");
                return;
            }
            shape.root = function.size() - 1;
        }
        std::uint8_t code = 0;
        if (!take(code)) return;
        if (code != kEnd) {
            --at_;
            stop("the shape has free variables, which have no value here");
            return;
        }
        shapes.push_back(shape);
    }

    bool read_operation(std::uint8_t code) {
        const Meaning meaning = code < table_.size() ? table_[code] : Meaning::kUnknown;
        if (meaning == Meaning::kUnknown) {
            --at_;
            return stop("operation " + std::to_string(code) +
                        " is not known or has no formula (free variables, oracles, nanfill)");
        }
        bool z = meaning == Meaning::kZ;
        if (meaning == Meaning::kConstant) {
            float value = 0;
            if (!take(value)) return false;
            if (!(value - value == 0)) return stop("a constant that is not finite");
            function.define(function_number(static_cast<double>(value)));
        } else if (meaning == Meaning::kX || meaning == Meaning::kY || meaning == Meaning::kZ) {
            function.define(meaning == Meaning::kX ? "x" : meaning == Meaning::kY ? "y" : "z");
        } else {
            const bool binary = meaning >= Meaning::kAdd;
            std::size_t left = 0;
            std::size_t right = 0;
            if (binary && !take_argument(right)) return false;
            if (!take_argument(left)) return false;
            if (!binary) right = left;
            z = has_z[left] || has_z[right];
            is_usual = is_usual || meaning == Meaning::kAdd || meaning == Meaning::kMultiply ||
                       meaning == Meaning::kMin;
            define_operation(meaning, left, right);
        }
        has_z.push_back(z);
        return true;
    }

    void define_operation(Meaning meaning, std::size_t a, std::size_t b) {
        static const std::array<const char*, 30> kBefore = {
            "",     "",     "",      "",      "",      "",       "square(", "sqrt(", "neg(",   "sin(",
            "cos(", "tan(", "asin(", "acos(", "atan(", "exp(",   "abs(",    "log(",  "recip(", "",
            "",     "min(", "max(",  "",      "",      "atan2(", "pow(",    "",      "mod(",   "compare("};
        const std::string_view before = kBefore[static_cast<std::size_t>(meaning)];
        switch (meaning) {
            case Meaning::kSame: return function.define("", a, "");
            case Meaning::kAdd: return function.define("", a, " + ", b, "");
            case Meaning::kMultiply: return function.define("", a, " * ", b, "");
            case Meaning::kSubtract: return function.define("", a, " - ", b, "");
            case Meaning::kDivide: return function.define("", a, " / ", b, "");
            case Meaning::kRoot:
                return function.define("sign(" + function_name(a) + ")*abs(" + function_name(a) + ")^(1/" +
                                       function_name(b) + ")");
            default: break;
        }
        if (meaning < Meaning::kAdd) return function.define(before, a, ")");
        function.define(before, a, ", ", b, ")");
    }

    const std::string& bytes_;
    const Table& table_;
    std::size_t at_ = 0;
};

}  // namespace

Model read_frep(const std::string& bytes, const std::string& source, const std::string& region,
                const ReadOptions& options) {
    FrepReader standard(bytes, kStandardTable);
    FrepReader packed(bytes, kPackedTable);
    const bool is_standard = standard.read();
    const bool is_packed = packed.read();
    if (!is_standard && !is_packed) throw Error(ExitCode::kInput, source + ": " + standard.problem);
    const FrepReader& reader = is_packed && !(is_standard && standard.is_usual) ? packed : standard;
    Model model;
    model.source = source;
    for (const Shape& shape : reader.shapes) {
        std::string name = shape.name.empty() ? region : shape.name;
        if (shape.name.empty() && reader.shapes.size() > 1) name += std::to_string(model.regions.size() + 1);
        add_function(model, reader.function.formula(shape.root), reader.has_z[shape.root], name, {}, options);
    }
    return model;
}

}  // namespace mortise::model_reader
