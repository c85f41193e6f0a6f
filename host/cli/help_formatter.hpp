// The text of --help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

namespace mortise::cli {

/// Help with one line per option: CLI11's own wraps at fixed columns and repeats types.
class HelpFormatter : public CLI::Formatter {
  public:
    explicit HelpFormatter(std::string usage) : usage_(std::move(usage)) {}

    std::string make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const override;

  private:
    std::string usage_;
};

}  // namespace mortise::cli
