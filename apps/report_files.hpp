#pragma once

#include <string_view>

namespace struna::apps {

// The page's parts: the files of the same names, and the chart library, put into the program when it is
// built.
extern const std::string_view report_html;
extern const std::string_view report_css;
extern const std::string_view report_axes_js;
extern const std::string_view report_plots_js;
extern const std::string_view report_elements_js;
extern const std::string_view report_bode_js;
extern const std::string_view report_stabilisation_js;
extern const std::string_view report_frame_js;
extern const std::string_view report_js;
extern const std::string_view simulate_report_js;
extern const std::string_view chart_js;

}  // namespace struna::apps
