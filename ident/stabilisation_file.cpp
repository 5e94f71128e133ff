#include "ident/stabilisation_file.hpp"

#include <fmt/format.h>

#include <iterator>

#include "ident/atomic_file.hpp"

namespace struna::ident {

void write_stabilisation(const Stabilisation& stabilisation, const std::string& file) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "order [-],natural_frequency [Hz],loss_factor [-],stability,column\n");
  for (const OrderPole& pole : stabilisation.poles)
    fmt::format_to(out, "{},{:.10g},{:.10g},{},{}\n", pole.order, pole.pole.natural_frequency_hz,
                   pole.pole.loss_factor, to_string(pole.stability),
                   pole.column < 0 ? "" : std::to_string(pole.column + 1));
  write_atomically(file, std::string_view(text.data(), text.size()));
}

}  // namespace struna::ident
