#include "ident/mode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr std::array<std::pair<ModeFlag, const char*>, 8> flag_words = {
    {{ModeFlag::coarse, "coarse"},
     {ModeFlag::close_modes, "close_modes"},
     {ModeFlag::double_mode, "double_mode"},
     {ModeFlag::may_be_two, "may_be_two"},
     {ModeFlag::noisy, "noisy"},
     {ModeFlag::edge, "edge"},
     {ModeFlag::poor_circle, "poor_circle"},
     {ModeFlag::not_converged, "not_converged"}}};

// The same function without the line at 0 Hz, where residual terms and circles have no meaning.
TransferFunction without_zero_line(const TransferFunction& tf) {
  const long skip = tf.lines() > 0 && tf.frequency_hz(0) <= 0.0 ? 1 : 0;
  if (skip == 0) return tf;
  TransferFunction result = tf;
  const long n = tf.lines() - skip;
  result.frequency_hz = tf.frequency_hz.tail(n);
  for (std::size_t k = 0; k < tf.outputs.size(); ++k) {
    result.outputs[k].value = tf.outputs[k].value.tail(n);
    if (tf.outputs[k].coherence.size() > 0) result.outputs[k].coherence = tf.outputs[k].coherence.tail(n);
    if (tf.outputs[k].sigma.size() > 0) result.outputs[k].sigma = tf.outputs[k].sigma.tail(n);
  }
  return result;
}

}  // namespace

std::string to_string(ModeFlag flag) {
  for (const auto& [known, word] : flag_words)
    if (known == flag) return word;
  throw Error("to_string(ModeFlag): not a flag");
}

ModeFlag mode_flag(const std::string& word) {
  std::string understood;
  for (const auto& [flag, known] : flag_words) {
    if (word == known) return flag;
    understood += (understood.empty() ? "" : ", ") + std::string(known);
  }
  throw Error(fmt::format("mode flag \"{}\" is not known; understood: {}", word, understood));
}

bool Mode::has(ModeFlag flag) const {
  return std::find(flags.begin(), flags.end(), flag) != flags.end();
}

FrfKind circle_form(FrfKind kind, fem::Damping damping) {
  switch (kind) {
    case FrfKind::dynamic_stiffness:
    case FrfKind::impedance:
    case FrfKind::apparent_mass:
      return FrfKind::apparent_mass;
    case FrfKind::receptance:
    case FrfKind::mobility:
    case FrfKind::accelerance:
      return damping == fem::Damping::structural ? FrfKind::receptance : FrfKind::mobility;
    case FrfKind::transmissibility:
    case FrfKind::unknown:
      break;
  }
  return kind;
}

TransferFunction to_circle_form(const TransferFunction& tf, fem::Damping damping) {
  if (tf.outputs.empty()) throw Error("to_circle_form: at least one output, got none");
  const FrfKind form = circle_form(tf.outputs.front().kind, damping);
  for (const auto& output : tf.outputs)
    if (circle_form(output.kind, damping) != form)
      throw Error(fmt::format(
          "to_circle_form: outputs of one family, got {} \"{}\" beside {} \"{}\"; identify them separately",
          to_string(tf.outputs.front().kind), tf.outputs.front().name, to_string(output.kind), output.name));
  const bool as_it_is = form == FrfKind::unknown || form == FrfKind::transmissibility;
  return without_zero_line(as_it_is ? tf : convert(tf, form));
}

}  // namespace struna::ident
