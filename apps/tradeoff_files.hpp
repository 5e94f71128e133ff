#pragma once

#include <string_view>

namespace struna::apps {

/// tradeoff_page.js, put into the program when it is built.
extern const std::string_view tradeoff_page_js;

}  // namespace struna::apps
