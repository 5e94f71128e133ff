#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ident/transfer_function.hpp"

namespace struna::apps {

// What the program's pages share: numbers for the script, and the frame that holds it. Included by the pages'
// own .cpp files only.

/// The number to `digits` significant digits: what a screen can show, and half the page's size. Not finite:
/// null.
nlohmann::json number(double value, int digits = 7);
nlohmann::json numbers(const Eigen::VectorXd& values, int digits = 7);
/// A list of rows.
nlohmann::json numbers_by_row(const Eigen::MatrixXd& values, int digits = 7);

nlohmann::json text_pairs(const std::vector<std::pair<std::string, std::string>>& pairs);

/// { frequency, outputs: [{ name, kind, unit, re, im, coherence?, sigma? }] }
nlohmann::json transfer_function_json(const ident::TransferFunction& tf);

struct PageSection {
  std::string id;
  std::string heading;
};

/// A self-contained page (chart library embedded) with these empty sections, which `script` fills from
/// `data`.
std::string render_page(const std::string& title, const std::vector<PageSection>& sections,
                        const nlohmann::json& data, std::string_view script);

}  // namespace struna::apps
