// SPDX-License-Identifier: Apache-2.0
// lucarium reproduce: experiments of papers, each a comparison and the values read off it. Declared in commands.h.
#include <algorithm>

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/compare/results/winners.h"
#include "lucarium/compare/run/comparison.h"
#include "lucarium/compare/run/dry_run.h"
#include "lucarium/technique/technique_folders.h"
#include "options/executor_arguments.h"
#include "options/options.h"
#include "outputs/plan_text.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

struct ReproduceArguments {
  std::string wanted;  ///< PAPER or PAPER/EXPERIMENT
  std::vector<fs::path> folders;
  bool list = false, full = false, dry_run = false;
  DeviceArguments device;
  ExecutorArguments executor;
  ComparisonOptions options;
};

const Paper& find_paper(const std::vector<Paper>& papers, const std::string& name) {
  std::vector<std::string> names;
  for (const Paper& paper : papers) {
    if (paper.name == name) return paper;
    names.push_back(paper.name);
  }
  throw_error(ErrorClass::usage, "no paper is called '{}'{}; `lucarium reproduce --list` names them", name,
              suggest_name(name, names));
}

/// What --list prints: all, those of a paper, or one experiment.
std::vector<Paper> listed_papers(const std::string& wanted, const std::vector<Paper>& papers) {
  if (wanted.empty()) return papers;
  const size_t slash = wanted.find('/');
  Paper paper = find_paper(papers, wanted.substr(0, slash));
  if (slash != std::string::npos) {
    const std::string name = wanted.substr(slash + 1);
    read_experiment(paper, name, false);  // throws where there is none
    paper.experiments = {name};
  }
  return {paper};
}

ordered_json list_json(const std::vector<Paper>& papers) {
  ordered_json list = ordered_json::array();
  for (const Paper& paper : papers) {
    ordered_json experiments = ordered_json::array();
    for (const std::string& name : paper.experiments) {
      const Experiment experiment = read_experiment(paper, name, false);
      experiments.push_back({{"id", experiment.id()}, {"title", experiment.title}, {"place", experiment.place}});
    }
    ordered_json entry = {{"name", paper.name}, {"citation", paper.citation}};
    if (!paper.technique.empty()) entry["technique"] = paper.technique;
    entry["experiments"] = experiments;
    list.push_back(std::move(entry));
  }
  return {{"schema", "lucarium-papers-1"}, {"papers", list}};
}

void print_list(const std::vector<Paper>& papers) {
  if (papers.empty()) print_result("no technique brings experiments\n");
  for (const Paper& paper : papers) {
    print_result("{}  ({})\n  {}\n", paper.name, paper.technique.empty() ? "of no paper" : paper.technique,
                 paper.citation);
    size_t width = 0;
    for (const std::string& name : paper.experiments) width = std::max(width, paper.name.size() + 1 + name.size());
    for (const std::string& name : paper.experiments) {
      const Experiment experiment = read_experiment(paper, name, false);
      print_result("    {:{}}  {} ({})\n", experiment.id(), width, experiment.title, experiment.place);
    }
  }
}

std::vector<Experiment> wanted_experiments(const ReproduceArguments& arguments, const std::vector<Paper>& papers) {
  if (arguments.wanted.empty()) throw_error(ErrorClass::usage, "which paper? `lucarium reproduce --list` names them");
  const size_t slash = arguments.wanted.find('/');
  const Paper& paper = find_paper(papers, arguments.wanted.substr(0, slash));
  std::vector<std::string> names = paper.experiments;
  if (slash != std::string::npos) names = {arguments.wanted.substr(slash + 1)};
  std::vector<Experiment> experiments;
  for (const std::string& name : names) experiments.push_back(read_experiment(paper, name, !arguments.full));
  const std::vector<std::string> device = arguments.device.in_comparison();
  for (Experiment& experiment : experiments) {
    std::vector<std::string>& words = experiment.comparison.device_arguments;
    words.insert(words.end(), device.begin(), device.end());
  }
  return experiments;
}

bool is_complete(const ComparisonResult& result) {
  const auto failed = [](const auto& entry) { return !entry.failure.empty(); };
  return std::none_of(result.pieces.begin(), result.pieces.end(), failed) &&
         std::none_of(result.scenes.begin(), result.scenes.end(),
                      [&](const SceneResult& scene) { return failed(scene) && !scene.left_out; });
}

/// An interrupted run is continued where it stopped; what is complete is only read again.
ComparisonResult run_experiment(const Experiment& experiment, const TechniqueRegistry& registry,
                                ComparisonOptions options) {
  options.folder = options.folder / experiment.name;
  options.experiment = experiment;
  options.resume = options.resume && fs::exists(options.folder / "comparison.json");
  return run_comparison(experiment.comparison, registry, options);
}

int reproduce_wanted(ReproduceArguments arguments, const Messages& messages) {
  const std::vector<Paper> papers = find_papers(technique_folders(arguments.folders));
  if (arguments.list) {
    const std::vector<Paper> listed = listed_papers(arguments.wanted, papers);
    if (messages.json) {
      print_result("{}\n", list_json(listed).dump(2));
    } else {
      print_list(listed);
    }
    return 0;
  }
  const std::vector<Experiment> experiments = wanted_experiments(arguments, papers);
  const TechniqueRegistry registry(arguments.folders);
  ComparisonOptions& options = arguments.options;
  arguments.device.apply_to(options, arguments.folders);
  options.executor = arguments.executor.resolved(arguments.device);
  if (!messages.quiet) options.progress = [](const std::string& line) { print_note("{}\n", line); };
  if (arguments.dry_run) {
    std::vector<std::pair<std::string, std::string>> plans;
    for (const Experiment& experiment : experiments) {
      throw_if_interrupted(experiment.id().c_str());
      if (options.progress) options.progress(fmt::format("{}: {}", experiment.id(), experiment.title));
      plans.emplace_back(experiment.id(), describe_plan(experiment.comparison, registry, options));
    }
    print_plans(plans, messages.json);
    return 0;
  }
  if (options.folder.empty()) throw_error(ErrorClass::usage, "no output folder given; add --output FOLDER");
  bool complete = true;
  ordered_json finished = ordered_json::array();
  const auto print_finished = [&] {
    if (messages.json)
      print_result("{}\n", ordered_json{{"schema", "lucarium-reproduce-1"}, {"experiments", finished}}.dump(2));
  };
  const KeepOnInterrupt keep_experiments;
  for (const Experiment& experiment : experiments) {
    throw_if_interrupted(experiment.id().c_str());
    if (options.progress) options.progress(fmt::format("{}: {}", experiment.id(), experiment.title));
    const ComparisonResult result = run_experiment(experiment, registry, options);
    if (result.interrupted) {
      // --resume would take what was to be replaced for results of this run.
      const bool old_left = options.overwrite && &experiment != &experiments.back();
      log_warning("interrupted: finished pieces are kept; continue with --resume{}",
                  old_left ? ", and run the experiments behind this one with --overwrite" : "");
      print_finished();
      return static_cast<int>(ErrorClass::interrupted);
    }
    complete &= is_complete(result);
    const fs::path folder = options.folder / experiment.name;
    finished.push_back({{"id", experiment.id()},
                        {"complete", is_complete(result)},
                        {"results", (folder / "results.json").string()},
                        {"report", (folder / "report.html").string()}});
    if (result.reproduction) finished.back()["reproduction"] = ordered_json::parse(result.to_json()).at("reproduction");
    if (result.reproduction && !messages.json)
      print_result("{}{}  report: {}\n\n", result.reproduction->table(), describe_winners(result),
                   (folder / "report.html").string());
  }
  print_finished();
  return complete ? 0 : static_cast<int>(ErrorClass::check_failed);
}

}  // namespace

void add_reproduce_command(Command program, Action& action) {
  auto arguments = std::make_shared<ReproduceArguments>();
  Command command = program.add_subcommand("reproduce", "repeat a paper's tables and figures as comparisons");
  command.option("experiment", arguments->wanted);
  command.option("--output", arguments->options.folder)
      .value_name("FOLDER")
      .default_text("none, with --list or --dry-run");
  command.flag("--overwrite", arguments->options.overwrite);
  command.flag("--resume", arguments->options.resume);
  command.flag("--list", arguments->list);
  command.flag("--dry-run", arguments->dry_run);
  command.flag("--full", arguments->full);
  add_technique_path(command, arguments->folders);
  arguments->device.add_to(command, true);
  arguments->executor.add_to(command);
  command.excludes({"--list"}, {"--output", "--overwrite", "--resume", "--dry-run", "--full"});
  command.excludes({"--list"}, device_option_names());
  command.excludes({"--dry-run"}, {"--resume", "--overwrite", "--executor", "--slurm"});
  command.excludes({"--list"}, {"--executor", "--slurm"});
  command.excludes({"--resume"}, {"--overwrite"});
  command.examples({"lucarium reproduce --list", "lucarium reproduce hermes2010/resolution -o results"},
                   "docs/reproducing.md");
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) { return reproduce_wanted(*arguments, messages); };
  });
}

}  // namespace lucarium::app
