// Arrays of the library as arrays of numpy: views, not copies.
#pragma once

#include <vector>

#include <pybind11/numpy.h>

namespace mortise::python {

namespace py = pybind11;

/// A read-only view of `values` in rows of `width` (0: one dimension), which keeps `owner` alive.
template <class T>
py::array view(const std::vector<T>& values, std::size_t width, const py::handle& owner) {
    std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(values.size())};
    if (width > 0) shape = {static_cast<py::ssize_t>(values.size() / width), static_cast<py::ssize_t>(width)};
    py::array array(py::dtype::of<T>(), shape, values.data(), owner);
    array.attr("flags").attr("writeable") = false;
    return array;
}

}  // namespace mortise::python
