#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace struna::apps {

/// A parameter that a map turns.
struct LimitAxis {
  std::string name;  ///< with its unit: "noise [% of diameter]"
  std::vector<double> values;
};

/// One use of a method at one place of a map: how far off, what it said about that, and which flags it
/// carried.
struct LimitTrial {
  std::vector<double> at;  ///< per axis of the map
  unsigned seed = 0;
  double error = 0.0;  ///< of the map's quantity, >= 0; not finite: a result that is no number
  double sigma = std::numeric_limits<double>::quiet_NaN();  ///< stated standard error; NaN: none stated
  double tolerance = 0.0;                                   ///< stated, of the same quantity
  bool refused = false;                                     ///< no result, and the program said so
  std::string flags;  ///< words joined by ';'; empty: a result without a flag
};

enum class Outcome { right, uncertain, wrong, refused };

/// Wrong: beyond five stated sigmas, or beyond both three sigmas and the stated tolerance; where no sigma is
/// stated, beyond the tolerance. Uncertain: beyond the tolerance too, but its sigma says so.
Outcome outcome(const LimitTrial& trial);
std::string to_string(Outcome outcome);  ///< "right", "uncertain", "wrong", "refused"

/// Where one method works, where it does not, and what it says.
struct LimitMap {
  std::string name;             ///< "circle"; names files, words of --map
  std::string title;            ///< "Circle fit: two modes side by side"
  std::string quantity;         ///< what the error is of; without a comma
  std::vector<LimitAxis> axes;  ///< across, up, and (where there is a third) one panel for each value
  std::string fails;            ///< what goes wrong beyond the border
  std::string sign;             ///< by what the program notices
  std::string then;             ///< what it then does
  std::vector<LimitTrial> trials;
};

/// Trials by outcome; the wrong without a flag are what a user must fear.
struct LimitCount {
  long right = 0;
  long right_flagged = 0;  ///< false alarms
  long uncertain = 0;
  long wrong = 0;
  long wrong_flagged = 0;
  long refused = 0;
  double flagged_share() const;      ///< of wrong results; 1 when there are none
  double false_alarm_share() const;  ///< of right results; 0 when there are none
  std::string flagged_text() const;  ///< these shares for readers: "97.8 %"; "–" of none
  std::string false_alarm_text() const;
};
LimitCount count_of(const LimitMap& map);
/// Of the trials with these values of the axes.
LimitCount count_at(const LimitMap& map, const std::vector<double>& at);

/// "What fails; noticed by …; then …": one sentence.
std::string sentence_of(const LimitMap& map);

/// limits.csv: map, three pairs parameter,value (empty where a map has fewer), seed, quantity, error, sigma,
/// tolerance, outcome, flags; a number that is not finite is an empty field.
std::string limits_csv(const std::vector<LimitMap>& maps);

/// How finely a map is drawn.
struct LimitRun {
  int seeds = 0;       ///< draws of the noise for each place; 0: each map's own choice
  int first_seed = 1;  ///< of the draws
  int every = 1;       ///< every which value of each axis, first and last always: 1 the whole map
  std::function<void(const std::string&)> progress = [](const std::string&) {};

  std::vector<unsigned> draws(int usual) const;                        ///< their seeds
  LimitAxis axis(std::string name, std::vector<double> values) const;  ///< thinned by `every`
};

/// Whether one of a run's warnings holds these words: the sign that a map is about.
bool told(const std::vector<std::string>& warnings, const std::string& words);

/// Calls `visit` with every combination of the axes' values, the last axis slowest.
void for_each_place(const std::vector<LimitAxis>& axes,
                    const std::function<void(const std::vector<double>&)>& visit);

}  // namespace struna::apps
