#include "client/evaluation/drive_picture.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/plot_data.h"

namespace dcloc {
namespace {

constexpr std::size_t kMaxEllipses = 40;  // on the whole map
constexpr std::size_t kMaxMarks = 4;      // scans that the close-up marks
constexpr double kSettled_s = 5.0;        // by then a track has got over its first pose's error
constexpr double kLandmarkMargin_m = 40.0;

// Colours that most kinds of colour blindness tell apart.
constexpr const char* kTruthColour = "#000000";
constexpr std::array kColours = {"#0072B2", "#D55E00"};

// How much larger ellipses must be drawn to be seen on a map of this extent: 1, 2, 5, 10, ...
int EllipseScale(const std::vector<Ellipse>& ellipses, double extent_m) {
  std::vector<double> diameters;
  diameters.reserve(ellipses.size());
  for (const Ellipse& e : ellipses) diameters.push_back(e.major_diameter_m);
  const double median_m = diameters.empty() ? extent_m : Quantile(diameters, 0.5);
  int scale = 1;
  for (const int step : {2, 5, 10, 20, 50, 100, 200, 500}) {
    if (step * median_m > 0.02 * extent_m) break;
    scale = step;
  }
  return scale;
}

// What a close-up shows.
struct CloseUp {
  Stamp stamp;
  Eigen::Vector2d centre;
  double half_m;
};

// Around the largest error of any outcome once it has settled; nothing when there are no answers.
std::optional<CloseUp> ChooseCloseUp(const std::vector<LabelledOutcome>& outcomes, bool is_track) {
  const ScanOutcome* worst = nullptr;
  for (const LabelledOutcome& labelled : outcomes) {
    const DriveOutcome& outcome = *labelled.outcome;
    const bool is_long = Seconds(outcome, outcome.scans.back()) > 2.0 * kSettled_s;
    for (const ScanOutcome& scan : outcome.scans) {
      const bool has_settled = !is_track || !is_long || Seconds(outcome, scan) > kSettled_s;
      if (!scan.answered() || !has_settled) continue;
      if (worst == nullptr || scan.error.translation_m > worst->error.translation_m) worst = &scan;
    }
  }
  if (worst == nullptr) return std::nullopt;
  return CloseUp{worst->answer.stamp, Position(worst->T_map_vehicle_true),
                 std::clamp(3.0 * worst->error.translation_m, 2.0, 50.0)};
}

// The scans of `outcome` that the close-up marks, thinned.
std::vector<const ScanOutcome*> MarkedScans(const DriveOutcome& outcome, const CloseUp& close_up) {
  const Box box = Box{close_up.centre, close_up.centre}.Grown(close_up.half_m);
  std::vector<const ScanOutcome*> within;
  for (const ScanOutcome& scan : outcome.scans) {
    if (scan.answered() && box.Contains(Position(scan.T_map_vehicle_true))) within.push_back(&scan);
  }
  std::vector<const ScanOutcome*> marked;
  const std::size_t stride = (within.size() + kMaxMarks - 1) / kMaxMarks;
  for (std::size_t i = stride / 2; i < within.size(); i += stride) marked.push_back(within[i]);
  return marked;
}

std::string Panel(double x, double y, double width, double height) {
  return absl::StrFormat("set origin %.3f,%.3f\nset size noratio\nset size %.3f,%.3f\n", x, y,
                         width, height);
}

std::string Range(const char* axis, double min, double max) {
  return absl::StrFormat("set %srange [%.3f:%.3f]\n", axis, min, max);
}

/// Composes the picture's panels from named data.
class Composer {
 public:
  Composer(const std::vector<LabelledOutcome>& outcomes, bool is_track)
      : outcomes_(outcomes),
        is_track_(is_track),
        box_(TrackBox(*outcomes.front().outcome).Grown(kLandmarkMargin_m)),
        close_up_(ChooseCloseUp(outcomes, is_track)) {
    const DriveOutcome& first = *outcomes.front().outcome;
    const auto ellipses = Ellipses(first, kMaxEllipses);
    ellipse_scale_ = EllipseScale(ellipses, (box_.max - box_.min).maxCoeff());
    data_ = Block("landmarks", LandmarkLines(*first.map, box_)) +
            Block("truth", TruthLines(first)) +
            Block("ellipses", EllipseLines(ellipses, ellipse_scale_));
    if (close_up_) AddMarks();
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      absl::StrAppend(&data_, Block(absl::StrCat("run", i), AnswerLines(*outcomes[i].outcome)),
                      Block(absl::StrCat("cdf", i), DistributionLines(*outcomes[i].outcome)));
    }
  }

  std::string Compose() const {
    return absl::StrCat(data_, "set multiplot\nset grid back lt 1 lc rgb '#d8d8d8' lw 0.6\n",
                        "set key opaque samplen 2 Left reverse\n", MapPanel(), CloseUpPanel(),
                        ErrorPanel(0.23, "Position error", "[m]", 4, 5),
                        ErrorPanel(0.0, "Heading error", "[deg]", 6, 7), DistributionPanel(),
                        "unset multiplot\n");
  }

 private:
  // One plot element for each outcome, the last drawn first so that the first lies on top.
  std::string Curves(const char* block, const std::string& columns,
                     const std::string& style) const {
    std::vector<std::string> curves;
    for (std::size_t i = outcomes_.size(); i-- > 0;) {
      curves.push_back(absl::StrFormat("$%s%d using %s %s lc rgb '%s' title '%s'", block, i,
                                       columns, style, kColours[i % kColours.size()],
                                       outcomes_[i].label));
    }
    return absl::StrJoin(curves, ", ");
  }

  void AddMarks() {
    const DriveOutcome& first = *outcomes_.front().outcome;
    const std::vector<const ScanOutcome*> marked = MarkedScans(first, *close_up_);
    std::vector<Ellipse> ellipses;
    ellipses.reserve(marked.size());
    for (const ScanOutcome* scan : marked) ellipses.push_back(PositionEllipse(scan->answer));
    data_ += Block("marked_ellipses", EllipseLines(ellipses, 1.0));
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      data_ += Block(absl::StrCat("mark", i), MarkLines(*outcomes_[i].outcome, marked));
    }
  }

  // Where the vehicle was at the marked scans and where it was said to be, joined.
  std::string Marks() const {
    std::string marks = ", $mark0 using 1:2 with points pt 7 ps 1.3 lc rgb '#000000' notitle";
    for (std::size_t i = outcomes_.size(); i-- > 0;) {
      absl::StrAppendFormat(&marks,
                            ", $mark%d using 1:2:($3-$1):($4-$2) with vectors nohead lw 1.2 lc rgb "
                            "'%s' notitle, $mark%d using 3:4 with points pt 7 ps 1.1 lc rgb '%s' "
                            "notitle",
                            i, kColours[i], i, kColours[i]);
    }
    return marks;
  }

  std::string TrackStyle(double width) const {
    return is_track_ ? absl::StrFormat("with lines lw %.1f", width) : "with points pt 7 ps 0.5";
  }

  // Landmarks, truth and answers, with ellipses from the block of that name.
  std::string Tracks(const char* ellipses, const std::string& ellipse_title,
                     double landmark_size) const {
    return absl::StrFormat(
        "plot $landmarks using 1:2 with points pt 7 ps %.2f lc rgb '#888888' title 'landmarks of "
        "the map', $truth using 1:2 with lines lw 3.5 lc rgb '%s' title 'reference track', %s, $%s "
        "using 1:2:3:4:5 with ellipses fc rgb '%s' fs transparent solid 0.12 border lc rgb '%s' "
        "title '%s'",
        landmark_size, kTruthColour, Curves("run", "2:3", TrackStyle(1.6)), ellipses,
        kColours.front(), kColours.front(), ellipse_title);
  }

  std::string MapPanel() const {
    return absl::StrCat(
        Panel(0.0, 0.46, 0.6, 0.54), "set size ratio -1\n", "set title ",
        Quote("Drive " + outcomes_.front().outcome->drive + " in the map"), " noenhanced\n",
        "set xlabel 'x_{map} [m]'\nset ylabel 'y_{map} [m]'\n",
        "set key outside bottom center horizontal\n", Range("x", box_.min.x(), box_.max.x()),
        Range("y", box_.min.y(), box_.max.y()),
        Tracks("ellipses", absl::StrCat("95 % ellipse, drawn ", ellipse_scale_, " times as large"),
               0.25),
        "\n");
  }

  std::string CloseUpPanel() const {
    if (!close_up_) return "";
    const auto& [stamp, centre, half_m] = *close_up_;
    const DriveOutcome& first = *outcomes_.front().outcome;
    const double time_s =
        std::chrono::duration<double>(stamp - first.scans.front().answer.stamp).count();
    return absl::StrCat(
        Panel(0.6, 0.46, 0.4, 0.54), "set size ratio -1\nunset key\n",
        absl::StrFormat("set title 'Largest error%s, at %.1f s: some scans, true and answered'\n",
                        is_track_ ? " once settled" : "", time_s),
        Range("x", centre.x() - half_m, centre.x() + half_m),
        Range("y", centre.y() - half_m, centre.y() + half_m),
        Tracks("marked_ellipses", "95 % ellipse", 0.8), Marks(), "\nset key\n");
  }

  std::string ErrorPanel(double y, const char* quantity, const char* unit, int column,
                         int bound_column) const {
    const DriveOutcome& first = *outcomes_.front().outcome;
    return absl::StrCat(
        Panel(0.0, y, 0.64, 0.23), "set key outside top center horizontal\n",
        absl::StrFormat("set title '%s over time'\nset xlabel 'time [s]'\nset ylabel '%s'\n",
                        quantity, unit),
        Range("x", 0.0, std::max(1.0, Seconds(first, first.scans.back()))), "set yrange [0:*]\n",
        absl::StrFormat("plot $run0 using 1:%d with filledcurves y1=0 fc rgb '%s' fs transparent "
                        "solid 0.15 title 'claimed 95 %% bound', %s\n",
                        bound_column, kColours.front(),
                        Curves("run", absl::StrFormat("1:%d", column), TrackStyle(1.4))));
  }

  std::string DistributionPanel() const {
    return absl::StrCat(Panel(0.64, 0.0, 0.36, 0.46), "set key inside bottom right vertical\n",
                        "set title 'Distribution of the position error'\n",
                        "set xlabel '[m]'\nset ylabel 'scans with no larger error [%]'\n",
                        "set xrange [0:*]\nset yrange [0:100]\n", "plot ",
                        Curves("cdf", "1:2", "with lines lw 2"), "\n");
  }

  const std::vector<LabelledOutcome>& outcomes_;
  bool is_track_;
  Box box_;
  std::optional<CloseUp> close_up_;
  int ellipse_scale_ = 1;
  std::string data_;
};

}  // namespace

Picture DrawDrive(const std::vector<LabelledOutcome>& outcomes, bool is_track) {
  return {.commands = Composer(outcomes, is_track).Compose(), .width_px = 1500, .height_px = 1500};
}

}  // namespace dcloc
