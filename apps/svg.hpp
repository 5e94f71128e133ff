#pragma once

#include <string>
#include <vector>

namespace struna::apps {

// Pieces of the pictures that the program draws.

/// `text` safe inside an element.
std::string escaped(const std::string& text);

/// Text broken at blanks to at most `width` bytes a line.
std::vector<std::string> wrapped(const std::string& text, std::size_t width);

/// `text` at x, y [px]; `anchor` start, middle or end; `more` further attributes.
std::string text_at(double x, double y, const std::string& anchor, const std::string& text,
                    const std::string& more = "");

/// The picture around `body` [px]: white ground, fonts, classes soft, small and title.
std::string svg_picture(double width, double height, const std::string& body);

}  // namespace struna::apps
