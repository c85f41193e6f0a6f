// The readers that read_model and parse_model choose from.
#pragma once

#include <string>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// OpenSCAD's .csg text (csg_reader.cpp). The one region is called `region`.
Model read_csg(const std::string& text, const std::string& source, const std::string& region,
               Facets facets = Facets::kSmooth);

/// Netgen's .geo text (geo_reader.cpp).
Model read_geo(const std::string& text, const std::string& source);

/// A function that is negative inside (vm_reader.cpp, frep_reader.cpp, formula_reader.cpp).
Model read_vm(const std::string& text, const std::string& source, const std::string& region,
              const ReadOptions& options);
Model read_frep(const std::string& bytes, const std::string& source, const std::string& region,
                const ReadOptions& options);
Model read_formula(const std::string& text, const std::string& source, const std::string& region,
                   const ReadOptions& options);

}  // namespace mortise::model_reader
