#pragma once

#include <string_view>

namespace struna::apps {

/// limit_page.js, put into the program when it is built.
extern const std::string_view limit_page_js;

}  // namespace struna::apps
