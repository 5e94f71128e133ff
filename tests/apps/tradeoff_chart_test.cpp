#include "apps/tradeoff_chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "apps/tradeoff_page.hpp"
#include "apps/tradeoff_svg.hpp"

namespace struna::apps {
namespace {

using testing::HasSubstr;
using testing::Not;

TradeoffRow row(const std::string& method, double value, double error, double seconds, bool usual = false) {
  return {method, "elements [-]", value, error, seconds, usual, false};
}

TradeoffChart chart_of(std::vector<TradeoffRow> rows) {
  TradeoffChart chart;
  chart.stage = "model";
  chart.problem = "wire <1>";
  chart.quantity = "frequency";
  chart.error_label = "largest relative error";
  chart.reference = "closed form";
  chart.rows = std::move(rows);
  mark_pareto(chart);
  return chart;
}

std::vector<bool> front_of(const TradeoffChart& chart) {
  std::vector<bool> front;
  for (const auto& r : chart.rows) front.push_back(r.pareto);
  return front;
}

TEST(TradeoffChart, FrontHoldsWhatNoOtherRowBeats) {
  const auto chart = chart_of({row("a", 1, 1e-1, 1.0), row("a", 2, 1e-2, 2.0), row("b", 1, 1e-1, 1.5),
                               row("b", 2, 5e-2, 0.5), row("b", 3, 1e-3, 9.0)});
  EXPECT_EQ(front_of(chart), (std::vector<bool>{false, true, false, true, true}));
}

TEST(TradeoffChart, EqualRowsAreBothOnTheFront) {
  EXPECT_EQ(front_of(chart_of({row("a", 1, 0.1, 1.0), row("b", 1, 0.1, 1.0)})),
            (std::vector<bool>{true, true}));
}

TEST(TradeoffChart, WhatDivergedIsNeverOnTheFront) {
  const auto chart = chart_of({row("a", 1, std::numeric_limits<double>::infinity(), 1e-9),
                               row("a", 2, std::nan(""), 1e-9), row("a", 3, 0.1, 1.0)});
  EXPECT_EQ(front_of(chart), (std::vector<bool>{false, false, true}));
  EXPECT_THAT(tradeoff_csv({chart}), HasSubstr(",1,,1e-09,0,0,"));  // an empty error
}

TEST(TradeoffChart, ErrorsBelowTheReferencesOwnAreNotToldApart) {
  auto chart = chart_of({row("a", 1, 1e-9, 2.0), row("a", 2, 1e-8, 1.0)});
  EXPECT_EQ(front_of(chart), (std::vector<bool>{true, true}));
  chart.reference_error = 1e-7;
  mark_pareto(chart);
  EXPECT_EQ(front_of(chart), (std::vector<bool>{false, true}));
  EXPECT_EQ(told_error(chart, chart.rows[0]), 1e-7);
}

TEST(TradeoffChart, OnlyRowsBetterInBothByTheFactorBeatTheDefault) {
  const auto chart = chart_of({row("a", 1, 1e-2, 1.0, true), row("b", 1, 1e-3, 0.7), row("c", 1, 1e-3, 0.6),
                               row("d", 1, 0.7e-2, 0.1), row("e", 1, 1e-5, 2.0)});
  const auto better = better_than_default(chart);
  ASSERT_EQ(better.size(), 1u);
  EXPECT_EQ(better.front().method, "c");
  EXPECT_TRUE(better_than_default(chart_of({row("a", 1, 1e-2, 1.0), row("b", 1, 1e-9, 1e-3)})).empty())
      << "no default, nothing to beat";
}

TEST(TradeoffChart, AdviceNamesTheQuickestRowThatReachesTheTarget) {
  auto chart = chart_of({row("a", 4, 5e-2, 1e-3), row("a", 8, 8e-3, 2e-3, true), row("b", 8, 2e-3, 5e-3)});
  chart.target = 1e-2;
  EXPECT_THAT(advice(chart), HasSubstr("take a, elements = 8 (0.8 % in 2 ms)"));
  EXPECT_THAT(advice(chart), HasSubstr("on the front"));
  chart.target = 5e-3;
  EXPECT_THAT(advice(chart), HasSubstr("take b, elements = 8"));
  chart.target = 1e-6;
  EXPECT_THAT(advice(chart), HasSubstr("nothing here reaches it; nearest is b, elements = 8"));
  chart.rows.clear();
  EXPECT_THAT(advice(chart), HasSubstr("nothing here gave a result"));
}

TEST(TradeoffChart, AdviceTellsWhatBeatsTheDefault) {
  const auto chart = chart_of({row("a", 4, 5e-2, 1.0, true), row("b", 8, 1e-2, 0.1)});
  EXPECT_THAT(advice(chart),
              HasSubstr("b, elements = 8 (1 % in 100 ms) is both quicker and more accurate, 10 "
                        "and 5 times"));
}

TEST(TradeoffChart, CsvHasTheColumnsThatAreDocumented) {
  const auto text = tradeoff_csv({chart_of({row("a", 4, 5e-2, 1.0, true)})});
  EXPECT_THAT(text, testing::StartsWith("stage,problem,method,knob,value,error,time_s,pareto,default,"));
  EXPECT_THAT(text, HasSubstr("\nmodel,wire <1>: frequency,a,elements [-],4,0.05,1,1,1,frequency,0\n"));
}

TEST(TradeoffChart, LabelsTellTheKnobWithItsUnit) {
  EXPECT_EQ(row_label(row("a", 28, 0, 0)), "elements = 28");
  EXPECT_EQ(row_label({"a", "step [s]", 1e-5, 0, 0, false, false}), "step = 1e-05 s");
  EXPECT_EQ(seconds_text(2.5), "2.5 s");
  EXPECT_EQ(seconds_text(2.5e-3), "2.5 ms");
  EXPECT_EQ(seconds_text(2.5e-5), "25 us");
}

TEST(TradeoffChart, TimesTheShortestRunAndStopsAtTheBudget) {
  int runs = 0;
  const auto work = [&] {
    volatile double sum = 0.0;
    for (int i = 0; i < 200000; ++i) sum = sum + 1.0;
    ++runs;
  };
  EXPECT_GT(best_seconds({3, 1e9}, work), 0.0);
  EXPECT_EQ(runs, 3);
  best_seconds({1000, 0.0}, work);
  EXPECT_EQ(runs, 4) << "one run at least, none beyond the budget";
}

TEST(TradeoffSvg, DrawsEveryFinitePointTheDefaultAndTheFront) {
  const auto svg = tradeoff_svg({chart_of({row("a", 4, 5e-2, 1.0, true), row("a", 8, 1e-2, 2.0),
                                           row("b", 8, std::numeric_limits<double>::infinity(), 0.1)})});
  EXPECT_THAT(svg, testing::StartsWith("<svg "));
  EXPECT_THAT(svg, HasSubstr("wire &lt;1&gt;"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_THAT(svg, HasSubstr("r=\"8\""));                   // the ring of the default
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray=\"5 4\""));  // the front
  EXPECT_THAT(svg, Not(HasSubstr("b (label")));             // a method without a point is not in the legend
}

TEST(TradeoffSvg, HoldsWithoutAnyPoint) {
  EXPECT_THAT(tradeoff_svg({chart_of({})}), Not(HasSubstr("nan")));
}

TEST(TradeoffPage, HoldsItsDataAndNothingFromElsewhere) {
  const auto page =
      tradeoff_page({{"model", "Beam model", {chart_of({row("a", 4, 5e-2, 1.0, true)})}}}, "struna x");
  EXPECT_THAT(page, HasSubstr("<section id=\"model\"><h2>Beam model</h2>"));
  EXPECT_THAT(page, HasSubstr("\"advice\":\"For 1 % in frequency"));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  EXPECT_THAT(page, Not(HasSubstr("{{")));
}

}  // namespace
}  // namespace struna::apps
