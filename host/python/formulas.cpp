#include "host/python/formulas.hpp"

#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>

#include "host/python/numbers.hpp"

namespace mortise::python {
namespace {

namespace py = pybind11;

constexpr std::size_t kLongest = 400;  ///< characters of a text that repr() shows

/// An operation and what it is of; a word without arguments is a coordinate or a number.
struct Operation {
    std::string word;
    std::vector<std::shared_ptr<Operation>> arguments;

    Operation(std::string said, std::vector<std::shared_ptr<Operation>> of = {})
        : word(std::move(said)), arguments(std::move(of)) {}
    Operation(const Operation&) = delete;
    Operation& operator=(const Operation&) = delete;
    /// Sums may have more terms than the stack has room for.
    ~Operation() {
        std::vector<std::shared_ptr<Operation>> left = std::move(arguments);
        while (!left.empty()) {
            const std::shared_ptr<Operation> last = std::move(left.back());
            left.pop_back();
            if (last.use_count() == 1)
                std::move(last->arguments.begin(), last->arguments.end(), std::back_inserter(left));
        }
    }
};

/// A value: shared parts are written, and evaluated, once.
struct Formula {
    std::shared_ptr<Operation> root;
};

Formula number(double value) {
    if (!std::isfinite(value)) throw py::value_error("a formula has finite numbers only");
    const std::string text = number_text(value);
    return {std::make_shared<Operation>(std::signbit(value) ? "(" + text + ")" : text)};
}

Formula combined(const std::string& word, const std::vector<Formula>& arguments) {
    std::vector<std::shared_ptr<Operation>> of;
    for (const Formula& argument : arguments) of.push_back(argument.root);
    return {std::make_shared<Operation>(word, std::move(of))};
}

/// A formula, or a number of Python's or numpy's.
std::optional<Formula> formula_of(const py::handle& value) {
    if (py::isinstance<Formula>(value)) return py::cast<Formula>(value);
    const bool is_scalar = py::isinstance<py::array>(value) && py::cast<py::array>(value).ndim() == 0;
    if (!PyNumber_Check(value.ptr()) || (PySequence_Check(value.ptr()) && !is_scalar) ||
        PyComplex_Check(value.ptr()))
        return std::nullopt;
    const double converted = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        return std::nullopt;
    }
    return number(converted);
}

/// Python's and numpy's a % b, which has the sign of b; `mod` of formulas has none.
Formula remainder(const Formula& a, const Formula& b) {
    const bool is_plain = b.root->arguments.empty() && b.root->word[0] != '(' && b.root->word[0] > '0' &&
                          b.root->word[0] <= '9';
    if (is_plain) return combined("mod", {a, b});
    return combined("-", {a, combined("*", {b, combined("floor", {combined("/", {a, b})})})});
}

Formula operation_of(const std::string& word, const std::vector<Formula>& arguments) {
    return word == "mod" ? remainder(arguments[0], arguments[1]) : combined(word, arguments);
}

bool is_infix(const std::string& word) { return word.size() == 1 && std::string("+-*/^").find(word) < 5; }

/// Operations as definitions, arguments before their users; no recursion.
std::string text_of(const Formula& formula) {
    std::unordered_map<const Operation*, std::string> names;
    std::size_t defined = 0;
    std::string text;
    std::vector<std::pair<const Operation*, std::size_t>> stack = {{formula.root.get(), 0}};
    while (!stack.empty()) {
        auto& [operation, next] = stack.back();
        if (next < operation->arguments.size()) {
            const Operation* const argument = operation->arguments[next++].get();
            if (names.find(argument) == names.end()) stack.push_back({argument, 0});
            continue;
        }
        std::string& name = names[operation];
        if (operation->arguments.empty()) {
            name = operation->word;
        } else {
            const auto argument = [&](std::size_t k) { return names.at(operation->arguments[k].get()); };
            name = "v" + std::to_string(++defined);
            text += name + " = ";
            if (is_infix(operation->word)) {
                text += argument(0) + " " + operation->word + " " + argument(1);
            } else {
                text += operation->word + "(" + argument(0);
                for (std::size_t k = 1; k < operation->arguments.size(); ++k) text += ", " + argument(k);
                text += ")";
            }
            text += ";\n";
        }
        stack.pop_back();
    }
    return text + names.at(formula.root.get());
}

/// numpy's functions by their names, and the words of formulas.
const std::map<std::string, const char*>& words() {
    // clang-format off
    static const std::map<std::string, const char*> all = {
        {"add", "+"}, {"subtract", "-"}, {"multiply", "*"}, {"divide", "/"}, {"true_divide", "/"},
        {"power", "^"}, {"float_power", "^"}, {"negative", "neg"}, {"absolute", "abs"}, {"fabs", "abs"},
        {"sqrt", "sqrt"}, {"square", "square"}, {"reciprocal", "recip"}, {"exp", "exp"}, {"log", "log"},
        {"sin", "sin"}, {"cos", "cos"}, {"tan", "tan"}, {"arcsin", "asin"}, {"arccos", "acos"},
        {"arctan", "atan"}, {"arctan2", "atan2"}, {"hypot", "hypot"}, {"minimum", "min"}, {"maximum", "max"},
        {"fmin", "min"}, {"fmax", "max"}, {"mod", "mod"}, {"remainder", "mod"}, {"floor", "floor"},
        {"ceil", "ceil"}, {"sign", "sign"}, {"sinh", "sinh"}, {"cosh", "cosh"}, {"tanh", "tanh"},
        {"cbrt", "cbrt"}, {"log2", "log2"}, {"log10", "log10"}, {"deg2rad", "radians"},
        {"radians", "radians"}, {"rad2deg", "degrees"}, {"degrees", "degrees"}};
    // clang-format on
    return all;
}

py::object combine_ufunc(const Formula&, const py::object& function, const std::string& method,
                         const py::args& inputs, const py::kwargs& options) {
    const auto name = py::cast<std::string>(function.attr("__name__"));
    const auto word = words().find(name);
    if (method != "__call__" || !options.empty())
        return py::reinterpret_borrow<py::object>(Py_NotImplemented);
    if (word == words().end())
        throw py::type_error("numpy." + name +
                             " is no function of formulas; docs/formulas.md has those that are");
    std::vector<Formula> arguments;
    for (const py::handle input : inputs) {
        const std::optional<Formula> argument = formula_of(input);
        if (!argument) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
        arguments.push_back(*argument);
    }
    return py::cast(operation_of(word->second, arguments));
}

[[noreturn]] void refuse_condition() {
    throw py::type_error(
        "a formula is neither true nor false: instead of conditions, min and max, take numpy.minimum and "
        "numpy.maximum of two, or functools.reduce(numpy.maximum, [...]) of several");
}

/// An operator with the formula on the left, and with it on the right.
void bind_operator(py::class_<Formula>& bound, const char* name, const char* word) {
    const auto make = [word](bool is_left) {
        return [word, is_left](const Formula& self, const py::object& other) -> py::object {
            const std::optional<Formula> second = formula_of(other);
            if (!second) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
            return py::cast(is_left ? operation_of(word, {self, *second})
                                    : operation_of(word, {*second, self}));
        };
    };
    bound.def(("__" + std::string(name) + "__").c_str(), make(true));
    bound.def(("__r" + std::string(name) + "__").c_str(), make(false));
}

/// A function of three formulas or numbers that numpy has not.
void bind_function(py::module_& module, const char* word, const std::array<const char*, 3>& names,
                   const char* help) {
    module.def(
        word,
        [word](const py::object& a, const py::object& b, const py::object& c) {
            std::vector<Formula> arguments;
            for (const py::object& argument : {a, b, c}) {
                const std::optional<Formula> formula = formula_of(argument);
                if (!formula)
                    throw py::type_error(std::string(word) + ": expected three numbers or formulas");
                arguments.push_back(*formula);
            }
            return combined(word, arguments);
        },
        py::arg(names[0]), py::arg(names[1]), py::arg(names[2]), help);
}

}  // namespace

void bind_formulas(py::module_& module) {
    py::class_<Formula> bound(
        module, "Formula",
        "A function of x, y, z: made from coordinates() by operators and numpy's functions.");
    bind_operator(bound, "add", "+");
    bind_operator(bound, "sub", "-");
    bind_operator(bound, "mul", "*");
    bind_operator(bound, "truediv", "/");
    bind_operator(bound, "mod", "mod");
    for (const char* comparison : {"__lt__", "__le__", "__gt__", "__ge__", "__eq__", "__ne__"})
        bound.def(comparison, [](const Formula&, const py::object&) -> bool { refuse_condition(); });
    bound.attr("__hash__") = py::none();
    for (const bool is_left : {true, false}) {
        bound.def(
            is_left ? "__pow__" : "__rpow__",
            [is_left](const Formula& self, const py::object& other, const py::object& modulus) -> py::object {
                const std::optional<Formula> second = formula_of(other);
                if (!second || !modulus.is_none())
                    return py::reinterpret_borrow<py::object>(Py_NotImplemented);
                return py::cast(is_left ? combined("^", {self, *second}) : combined("^", {*second, self}));
            },
            py::arg("other"), py::arg("modulus") = py::none());
    }
    bound.def("__neg__", [](const Formula& self) { return combined("neg", {self}); })
        .def("__pos__", [](const Formula& self) { return self; })
        .def("__abs__", [](const Formula& self) { return combined("abs", {self}); })
        .def("__copy__", [](const Formula& self) { return self; })
        .def("__deepcopy__", [](const Formula& self, const py::dict&) { return self; })
        .def("__bool__", [](const Formula&) -> bool { refuse_condition(); })
        .def("__array_ufunc__", combine_ufunc)
        .def(
            "clip",  // which numpy.clip calls
            [](const Formula& self, const py::object& low, const py::object& high, const py::object& out) {
                const std::optional<Formula> least = formula_of(low), most = formula_of(high);
                if (!least || !most || !out.is_none())
                    throw py::type_error("clip: expected two numbers or formulas, and no out");
                return combined("clamp", {self, *least, *most});
            },
            py::arg("low"), py::arg("high"), py::arg("out") = py::none())
        .def("__str__", text_of)
        .def("__repr__", [](const Formula& self) {
            const std::string text = text_of(self);
            return "<mortise.Formula: " + (text.size() > kLongest ? text.substr(0, kLongest) + "…" : text) +
                   ">";
        });
    bind_function(module, "smin", {"a", "b", "width"},
                  "The smaller of a and b, blended where they differ by less than width: a smooth union.");
    bind_function(
        module, "smax", {"a", "b", "width"},
        "The larger of a and b, blended where they differ by less than width: a smooth intersection.");
    bind_function(module, "smoothstep", {"low", "high", "a"},
                  "0 up to low, 1 from high on, and smooth between.");
    module.def(
        "coordinates",
        [] {
            const auto coordinate = [](const char* name) {
                return Formula{std::make_shared<Operation>(name)};
            };
            return py::make_tuple(coordinate("x"), coordinate("y"), coordinate("z"));
        },
        "The formulas x, y and z.");
}

std::string formula_text(const py::object& formula, const std::string& before) {
    if (py::isinstance<py::str>(formula)) return py::cast<std::string>(formula);
    py::object made = formula;
    if (PyCallable_Check(formula.ptr()) != 0)
        made = formula(*py::module_::import("mortise").attr("coordinates")());
    const std::optional<Formula> result = formula_of(made);
    if (!result)
        throw py::type_error(
            before + "expected a formula: a text, or what coordinates() and numpy's functions make, not " +
            std::string(py::repr(made)));
    return text_of(*result);
}

}  // namespace mortise::python
