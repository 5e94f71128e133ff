// What the program answers to input that it cannot use: exit 1, one line "struna: FILE:LINE: what is wrong",
// and no file, not even a temporary one, left behind. Wrong usage: exit 2.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::set<std::string> files_in(const Folder& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    names.insert(fs::relative(entry.path(), folder.path()).string());
  }
  return names;
}

/// A record of a plain spring, coherent throughout, with a line replaced at will (lines count from 1, the
/// header's).
std::string record(long rows, long line = 0, const std::string& instead = "") {
  std::string text = "time [s],displacement [m],force_y [N]\n";
  for (long i = 0; i < rows; ++i) {
    const double t = 1e-3 * static_cast<double>(i);
    const double u = 1e-3 * std::sin(300 * t + 100 * t * t);
    text += line == i + 2 ? instead + "\n"
                          : std::to_string(t) + "," + std::to_string(u) + "," + std::to_string(u) + "\n";
  }
  return text;
}

std::string rows_of_constant_input(long rows) {
  std::string text;
  for (long i = 0; i < rows; ++i)
    text += std::to_string(1e-3 * static_cast<double>(i)) + ",0.5," + std::to_string(i % 7) + "\n";
  return text;
}

const std::string& scene = straight_wire_scene;

/// The scene with one line replaced.
std::string scene_with(const std::string& line, const std::string& instead) {
  std::string text = scene;
  const std::size_t at = text.find(line + "\n");
  EXPECT_NE(at, std::string::npos) << line;
  return text.replace(at, line.size(), instead);
}

const std::string frf_command = "frf a.csv --input displacement --output force_y -o out.csv";

struct Case {
  std::string name;
  std::function<void(const Folder&)> prepare;
  std::string arguments;
  std::string begins;  ///< what the line on stderr begins with
};

void PrintTo(const Case& tried, std::ostream* out) {
  *out << tried.name;
}

Case record_case(const std::string& name, const std::string& content, const std::string& begins) {
  return {name, [content](const Folder& folder) { folder.write("a.csv", content); }, frf_command, begins};
}

Case scene_case(const std::string& name, const std::string& content, const std::string& begins) {
  return {name, [content](const Folder& folder) { folder.write("s.toml", content); },
          "eigen s.toml --modes 3 -o out.csv", begins};
}

const std::string tube = R"([[body]]
name = "tube"
points = [[0.1,0,0], [0.5,0,0]]
outer_diameter = 0.0095
inner_diameter = 0.0035
density = 4535
elements = 8
material = { youngs_modulus = 60e9, loss_factor = 0.02 }
)";

std::string contact_of_gap(const std::string& gap) {
  return "[[contact]]\ninside = \"wire\"\noutside = \"tube\"\ngap = " + gap + "\nstiffness = 1e5\n";
}

/// A scene with a [simulation] behind it; `duration`: a line in place of the usual one.
Case simulate_case(const std::string& name, const std::string& content, const std::string& duration,
                   const std::string& begins) {
  const std::string simulation = "[simulation]\n" + (duration.empty() ? "duration = 0.01" : duration) +
                                 "\nexcitation = { kind = \"sine\", frequency = 50, acceleration = 10 }\n";
  return {name, [=](const Folder& folder) { folder.write("s.toml", content + simulation); },
          "simulate s.toml -o out.csv", begins};
}

Case file_case(const std::string& name, const std::string& file, const std::string& content,
               const std::string& arguments, const std::string& begins) {
  return {name,
          [file, content](const Folder& folder) {
            folder.write("s.toml", scene);
            folder.write(file, content);
          },
          arguments, begins};
}

const std::string trfam =
    "frequency [Hz],force_y_re [N/m],force_y_im [N/m]\n1,1,0\n2,1,0\n3,1,0\n4,1,0\n5,1,0\n6,1,0\n";
const std::string study =
    "scene = \"s.toml\"\nrecords = [\"a.csv\"]\ninput = \"displacement\"\noutputs = [\"force_y\"]\n";

std::vector<Case> cases() {
  const auto nothing = [](const Folder&) {};
  return {
      // Records.
      record_case("MissingColumn", "time [s],displacement [m],force_x [N]\n0,0,0\n1,1,1\n",
                  "struna: a.csv:1: "),
      record_case("UnknownUnit", "time [s],displacement [furlong],force_y [N]\n0,0,0\n1,1,1\n",
                  "struna: a.csv:1: "),
      record_case("NoUnit", "time [s],displacement,force_y [N]\n0,0,0\n1,1,1\n", "struna: a.csv:1: "),
      record_case("TimeNotUniform", record(5000, 1234, "1.2325,0,0"), "struna: a.csv:1234: "),
      record_case("TimeStandsStill", record(5000, 100, "0.097,0,0"), "struna: a.csv:100: "),
      record_case("NotANumber", record(5000, 77, "0.075,nan,0"), "struna: a.csv:77: "),
      record_case("Infinity", record(5000, 77, "0.075,inf,0"), "struna: a.csv:77: "),
      record_case("TextInANumber", record(5000, 4321, "4.319,1e-3x,0"), "struna: a.csv:4321: "),
      record_case("EmptyField", record(5000, 9, "0.007,,0"), "struna: a.csv:9: "),
      record_case("RowTooShort", record(5000, 9, "0.007,0"), "struna: a.csv:9: "),
      record_case("RowTooLong", record(5000, 9, "0.007,0,0,0"), "struna: a.csv:9: "),
      record_case("EmptyFile", "", "struna: a.csv"),
      record_case("OneLineFile", "time [s],displacement [m],force_y [N]\n", "struna: a.csv"),
      record_case("RecordTooShort", record(3), "struna: a.csv"),
      record_case("ConstantInput", "time [s],displacement [m],force_y [N]\n" + rows_of_constant_input(2000),
                  "struna: a.csv: input 'displacement' is constant"),
      {"OutputNamedTwice", [](const Folder& folder) { folder.write("a.csv", record(5000)); },
       frf_command + " --output force_y", "struna: a.csv: column 'force_y' is named twice"},
      {"ConstantForceOfAHit",
       [](const Folder& folder) {
         folder.write("a.csv", "time [s],displacement [m],force_y [N]\n" + rows_of_constant_input(2000));
       },
       frf_command + " --impact", "struna: a.csv: the force is constant"},
      {"TheSameRecordTwice",
       [](const Folder& folder) {
         folder.write("a.csv", record(5000));
         folder.write("b.csv", record(5000));
       },
       "frf a.csv b.csv --input displacement --output force_y -o out.csv",
       "struna: b.csv: holds the same record as a.csv"},
      {"MissingFile", nothing, frf_command, "struna: a.csv: "},
      {"FolderForAFile", [](const Folder& folder) { fs::create_directory(folder / "a.csv"); }, frf_command,
       "struna: a.csv: "},
      {"RecordShorterThanTheResolutionAsks",
       [](const Folder& folder) { folder.write("a.csv", record(2000)); }, frf_command + " --resolution 0.01",
       "struna: a.csv"},
      {"BandBeyondTheLines", [](const Folder& folder) { folder.write("a.csv", record(5000)); },
       frf_command + " --band 2000:3000", "struna: a.csv"},
      {"OutputIntoAFolderThatIsNotThere", [](const Folder& folder) { folder.write("a.csv", record(5000)); },
       "frf a.csv --input displacement --output force_y --resolution 5 -o absent/out.csv",
       "struna: absent/out.csv: "},
      {"OutputOntoAFolder",
       [](const Folder& folder) {
         folder.write("a.csv", record(5000));
         fs::create_directory(folder / "out.csv");
       },
       frf_command + " --resolution 5", "struna: out.csv: "},
      // Scenes.
      scene_case("BodyOfNoLength",
                 scene_with("points = [[0,0,0], [0.68,0,0]]", "points = [[1,0,0], [1,0,0]]"),
                 "struna: s.toml:3: "),
      scene_case("UnknownKey", scene_with("elements = 10", "element = 10"), "struna: s.toml:6: "),
      scene_case("ContradictoryKeys", scene_with("elements = 10", "area = 1e-6"), "struna: s.toml:6: "),
      scene_case("WrongType", scene_with("density = 7650", "density = \"steel\""), "struna: s.toml:5: "),
      scene_case("BrokenToml", scene_with("density = 7650", "density = = 7650"), "struna: s.toml:5: "),
      scene_case("EmptyScene", "", "struna: s.toml: "),
      scene_case("NoModulus", scene_with("youngs_modulus = 120e9", ""), "struna: s.toml: "),
      scene_case("MoreElementsThanDigits", scene_with("elements = 10", "elements = 100000"),
                 "struna: s.toml:6: body.elements must be from 1 to 1000"),
      scene_case("OnePoint", scene_with("points = [[0,0,0], [0.68,0,0]]", "points = [[0,0,0]]"),
                 "struna: s.toml:3: "),
      simulate_case("SimulationWithoutModulus", scene_with("youngs_modulus = 120e9", ""), "",
                    "struna: s.toml: body 'wire' has no youngs_modulus"),
      simulate_case("SimulationOfOneSample", scene, "duration = 1.5e-4",
                    "struna: the duration 0.00015 s holds one sample"),
      simulate_case("ContactWithoutGap", scene + tube + contact_of_gap("0"), "",
                    "struna: s.toml:27: contact.gap must be > 0"),
      simulate_case("ContactGivenTwice", scene + tube + contact_of_gap("1e-4") + contact_of_gap("1e-4"), "",
                    "struna: s.toml:31: contact.outside repeats the contact of 'wire' and 'tube'"),
      {"NothingMeasured",
       [](const Folder& folder) { folder.write("s.toml", scene.substr(0, scene.find("[measure]"))); },
       "--quiet predict s.toml -o out.csv", "struna: s.toml: the scene needs a [measure]"},
      {"MissingScene", nothing, "eigen s.toml --modes 3 -o out.csv", "struna: s.toml: "},
      {"FolderForAScene", [](const Folder& folder) { fs::create_directory(folder / "s.toml"); },
       "eigen s.toml --modes 3 -o out.csv", "struna: s.toml: "},
      // Transfer functions, modes, parameters.
      file_case("TransferFunctionWithoutPairs", "t.csv", "frequency [Hz],force_y_re [N/m]\n1,1\n2,1\n",
                "modes t.csv -o out.csv", "struna: t.csv:1: "),
      file_case("TransferFunctionWithoutFrequency", "t.csv", "f,re,im\n1,1,0\n", "modes t.csv -o out.csv",
                "struna: t.csv:1: "),
      file_case("TransferFunctionWithFallingFrequency", "t.csv",
                "frequency [Hz],re,im\n1,1,0\n3,1,0\n2,1,0\n", "modes t.csv -o out.csv", "struna: t.csv:4: "),
      file_case("TransferFunctionEmpty", "t.csv", "", "modes t.csv -o out.csv", "struna: t.csv"),
      file_case("ModesWithText", "m.csv", "natural_frequency [Hz],loss_factor [-]\n24.4,0.02\nabc,0.02\n",
                "fit s.toml m.csv -o out.toml", "struna: m.csv:3: "),
      file_case("ModesWithoutFrequency", "m.csv", "mode,loss_factor [-]\n1,0.02\n",
                "fit s.toml m.csv -o out.toml", "struna: m.csv:1: "),
      file_case("ModesEmpty", "m.csv", "", "fit s.toml m.csv -o out.toml", "struna: m.csv"),
      file_case("ParametersBroken", "p.toml", "body = \"wire\"\n[modulus\n",
                "predict s.toml --parameters p.toml --band 10:100 --resolution 10 -o out.csv",
                "struna: p.toml:2: "),
      file_case("ParametersOfAnotherBody", "p.toml",
                "body = \"band\"\n[rayleigh]\nalpha = 1\nbeta = 0\nalpha_sigma = 0\nbeta_sigma = 0\n"
                "[modulus]\nfrequency = [20]\nvalue = [1e11]\nsigma = [1e9]\n"
                "[modulus.law]\nkind = \"constant\"\nvalue = 1e11\n"
                "[loss_factor]\nfrequency = [20]\nvalue = [0.01]\nsigma = [0.001]\n"
                "[loss_factor.law]\nkind = \"constant\"\nvalue = 0.01\n",
                "predict s.toml --parameters p.toml --band 10:100 --resolution 10 -o out.csv",
                "struna: p.toml: belongs to body 'band'"),
      file_case("LikeFileBroken", "t.csv", "frequency [Hz],force_y_re [N/m]\n1,1\n",
                "predict s.toml --like t.csv -o out.csv", "struna: t.csv:1: "),
      file_case("ComparedFileMissing", "t.csv",
                "frequency [Hz],force_q_re [N/m],force_q_im [N/m]\n1,1,0\n2,1,0\n",
                "compare t.csv absent.csv -o out.csv", "struna: absent.csv: "),
      file_case("OutputsOfTwoFamilies", "t.csv",
                "frequency [Hz],a_re [N/m],a_im [N/m],b_re [m/N],b_im [m/N]\n1,1,0,1,0\n2,1,0,1,0\n"
                "3,1,0,1,0\n4,1,0,1,0\n5,1,0,1,0\n6,1,0,1,0\n",
                "modes t.csv -o out.csv", "struna: t.csv: outputs of one family"),
      // Studies.
      file_case("StudyOfAMissingScene", "study.toml",
                "scene = \"absent.toml\"\nrecords = [\"a.csv\"]\ninput = \"displacement\"\noutputs = "
                "[\"force_y\"]\n",
                "identify study.toml -o out", "struna: absent.toml: "),
      file_case("StudyOfMissingRecords", "study.toml", study, "identify study.toml -o out",
                "struna: a.csv: "),
      file_case("StudyWithAnUnknownKey", "study.toml", study + "[transfer]\nresolutoin = 1\n",
                "identify study.toml -o out",
                "struna: study.toml:6: transfer.resolutoin is not a known key; did you mean"),
      file_case(
          "StudyOfAnOutputThatTheSceneDoesNotRead", "study.toml",
          "scene = \"s.toml\"\nrecords = [\"a.csv\"]\ninput = \"displacement\"\noutputs = [\"force_q\"]\n",
          "identify study.toml -o out", "struna: study.toml: "),
      file_case("IdentifyIntoAFile", "study.toml", study, "identify study.toml -o s.toml",
                "struna: s.toml: is a file"),
      file_case("IdentifyOfABrokenRecord", "study.toml",
                "scene = \"s.toml\"\nrecords = [\"study.toml\"]\ninput = \"displacement\"\noutputs = "
                "[\"force_y\"]\n",
                "identify study.toml -o out", "struna: study.toml:1: "),
  };
}

class BadInput : public testing::TestWithParam<Case> {};

TEST_P(BadInput, IsToldInOneLineAndLeavesNoFile) {
  const Case& tried = GetParam();
  const Folder folder;
  tried.prepare(folder);
  const std::set<std::string> before = files_in(folder);
  const ProgramRun run = run_struna(tried.arguments, folder);
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_THAT(run.err, StartsWith(tried.begins));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(files_in(folder), before);
  // Files and options, not the library's functions.
  EXPECT_THAT(run.err, Not(ContainsRegex("[a-z]+_[a-z_]+: "))) << run.err;
}

INSTANTIATE_TEST_SUITE_P(Tried, BadInput, testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.name; });

TEST(BadInputKeeps, AnOlderOutputWhenTheNewRunFails) {
  const Folder folder;
  folder.write("a.csv", record(5000, 4900, "x,0,0"));
  folder.write("out.csv", "older");
  EXPECT_EQ(run_struna(frf_command, folder).exit_code, 1);
  EXPECT_EQ(read_text(folder / "out.csv"), "older");
}

TEST(BadInputKeeps, TheProgramFromRunningAsIfItHadSucceededWhereNothingMayBeWritten) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  const Folder folder;
  folder.write("a.csv", record(5000));
  fs::create_directory(folder / "locked");
  fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  const ProgramRun run =
      run_struna("frf a.csv --input displacement --output force_y -o locked/out.csv", folder);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, StartsWith("struna: locked/out.csv: "));
}

/// A line for each command that writes a file, with IN for a file that it reads.
struct Overwriting {
  const char* input;
  const char* arguments;
};

TEST(WrongUsage, NoCommandWritesOverAFileThatItReads) {
  const Folder folder;
  const auto link = folder / "link";
  for (const Overwriting& tried :
       std::vector<Overwriting>{{"a.csv", "frf a.csv --input displacement --output force_y"},
                                {"b.csv", "frf a.csv b.csv --input displacement --output force_y"},
                                {"t.csv", "modes t.csv"},
                                {"s.toml", "fit s.toml m.csv"},
                                {"m.csv", "fit s.toml m.csv"},
                                {"s.toml", "predict s.toml"},
                                {"p.toml", "predict s.toml --parameters p.toml"},
                                {"t.csv", "predict s.toml --like t.csv"},
                                {"t.csv", "compare t.csv m.csv"},
                                {"m.csv", "compare t.csv m.csv"},
                                {"s.toml", "eigen s.toml"},
                                {"p.toml", "eigen s.toml --parameters p.toml"},
                                {"s.toml", "simulate s.toml"},
                                {"p.toml", "simulate s.toml --parameters p.toml"}}) {
    for (const char* name : {"a.csv", "b.csv", "t.csv", "m.csv", "s.toml", "p.toml"})
      folder.write(name, "not even looked at");
    fs::remove(link);
    fs::create_symlink(tried.input, link);
    for (const std::string& to : {std::string(tried.input), std::string("./") + tried.input, link.string()}) {
      const ProgramRun run = run_struna(tried.arguments + (" -o " + to), folder);
      EXPECT_EQ(run.exit_code, 2) << tried.arguments << " " << to << "\n" << run.err;
      EXPECT_THAT(run.err, StartsWith("struna: -o " + to + ": would overwrite its own input"))
          << tried.arguments;
      EXPECT_EQ(read_text(folder / tried.input), "not even looked at");
    }
  }
}

TEST(WrongUsage, NorOverAFileThatAStudyOrASceneNames) {
  const Folder folder;
  const std::string records = record(5000);
  folder.write("trfam.csv", records);
  folder.write("s.toml", scene);
  folder.write("study.toml",
               "scene = \"s.toml\"\nrecords = [\"trfam.csv\"]\ninput = \"displacement\"\noutputs = "
               "[\"force_y\"]\n");
  const ProgramRun identify = run_struna("identify study.toml -o .", folder);
  EXPECT_EQ(identify.exit_code, 2) << identify.err;
  EXPECT_THAT(identify.err, HasSubstr("would overwrite its own input"));
  EXPECT_EQ(read_text(folder / "trfam.csv"), records);

  folder.write("driven.toml", scene +
                                  "[simulation]\nduration = 1\nexcitation = { kind = \"record\", file = "
                                  "\"trfam.csv\", column = \"displacement\" }\n");
  for (const char* arguments :
       {"simulate driven.toml -o trfam.csv", "simulate driven.toml -o r.csv --contacts trfam.csv"}) {
    const ProgramRun simulate = run_struna(arguments, folder);
    EXPECT_EQ(simulate.exit_code, 2) << simulate.err;
    EXPECT_THAT(simulate.err, HasSubstr("would overwrite its own input"));
    EXPECT_EQ(read_text(folder / "trfam.csv"), records);
  }
  EXPECT_EQ(run_struna("simulate driven.toml -o a.csv --contacts a.csv", folder).exit_code, 2);
}

TEST(WrongUsage, AMisspeltCommandOrOptionIsNamedWithTheOneThatIsMeant) {
  const Folder folder;
  folder.write("t.csv", trfam);
  const std::pair<const char*, const char*> tried[] = {
      {"frobnicate", "struna: unknown command 'frobnicate'; there are frf, modes, "},
      {"mode t.csv -o out.csv", "struna: unknown command 'mode'; did you mean modes? "},
      {"--quiet simulte s.toml", "struna: unknown command 'simulte'; did you mean simulate? "},
      {"", "struna: a command is needed: frf, modes, "},
      {"modes t.csv -o out.csv --bnad 10:100", "struna: unknown option --bnad; did you mean --band? "},
      {"modes t.csv --bnad=10:100", "struna: unknown option --bnad; did you mean --band? "},
      {"frf a.csv --inptu x --output y -o out.csv", "struna: unknown option --inptu; did you mean --input? "},
      {"modes t.csv -o out.csv --qiet", "struna: unknown option --qiet; did you mean --quiet? "},
      {"modes t.csv -o out.csv --frob", "struna: unknown option --frob "},
      {"--frob modes t.csv -o out.csv", "struna: unknown option --frob "}};
  for (const auto& [arguments, begins] : tried) {
    const ProgramRun run = run_struna(arguments, folder);
    EXPECT_EQ(run.exit_code, 2) << arguments << "\n" << run.err;
    EXPECT_THAT(run.err, StartsWith(begins)) << arguments;
  }
}

TEST(WrongUsage, WordsMayBeWrittenInCapitals) {
  const Folder folder;
  folder.write("a.csv", record(5000));
  EXPECT_EQ(run_struna(frf_command + " --estimator H1 --window Hann", folder).exit_code, 0);
}

TEST(WrongUsage, IsExitTwoAndOneLineThatPointsToTheHelp) {
  const Folder folder;
  folder.write("s.toml", scene);
  folder.write("t.csv", trfam);
  for (const char* arguments :
       {"", "frob", "frf", "frf a.csv --input x -o out.csv",
        "frf a.csv --input x --output y --frob -o out.csv",
        "frf a.csv --input x --output y --form banana -o out.csv",
        "frf a.csv --input x --output y --estimator h9 -o out.csv",
        "frf a.csv --input x --output y --band 5 -o out.csv", "modes t.csv --band 20:10 -o out.csv",
        "modes t.csv --method magic -o out.csv", "modes t.csv --damping dry -o out.csv", "fit s.toml",
        "predict s.toml --damping dry -o out.csv", "compare t.csv", "identify", "identify study.toml",
        "eigen", "eigen s.toml --modes x"}) {
    const ProgramRun run = run_struna(arguments, folder);
    EXPECT_EQ(run.exit_code, 2) << arguments << "\n" << run.err;
    EXPECT_THAT(run.err, StartsWith("struna: ")) << arguments;
    EXPECT_THAT(run.err, HasSubstr("--help)")) << arguments;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << arguments << "\n" << run.err;
    EXPECT_FALSE(fs::exists(folder / "out.csv")) << arguments;
  }
}

}  // namespace
}  // namespace struna::tests
