#include "core/map/landmark_fusion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/map/height_fit.h"
#include "core/map/point_grid.h"

namespace dcloc {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr int kRounds = 3;  // of joining and moving; returns hardly change owner after them
constexpr double kGridCell_m = 1.0;  // of the look-up: about as far as a return joins
// Two standard deviations in the plane (86 % of a scatterer's returns), and as much of them in
// space.
constexpr double kPlanarGate = 4.0;
constexpr double kSpatialGate = 5.5;
// The reference poses' own error, which repeats from scan to scan and so never averages out.
constexpr double kFloor_m2 = 0.05 * 0.05;

Eigen::Matrix3d MeasurementCovariance(const MapReturn& r) {
  const std::array<float, 6>& c = r.covariance_m2;
  Eigen::Matrix3d covariance;
  covariance << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  return covariance;
}

// `covariance` without its negative part.
template <int Dim>
Eigen::Matrix<double, Dim, Dim> ClipToPsd(const Eigen::Matrix<double, Dim, Dim>& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Dim, Dim>> solver(covariance);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
         solver.eigenvectors().transpose();
}

// The returns of each landmark: those of landmark i are members[begin[i]] .. members[begin[i + 1]].
struct Groups {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> members;

  std::span<const std::uint32_t> Of(std::size_t landmark) const {
    return std::span(members).subspan(begin[landmark], begin[landmark + 1] - begin[landmark]);
  }
};

Groups GroupByOwner(std::span<const std::uint32_t> owners, std::size_t owner_count) {
  Groups groups{.begin = std::vector<std::uint32_t>(owner_count + 1, 0), .members = {}};
  for (const std::uint32_t owner : owners) {
    if (owner != kNone) ++groups.begin[owner + 1];
  }
  std::partial_sum(groups.begin.begin(), groups.begin.end(), groups.begin.begin());
  groups.members.resize(groups.begin.back());
  std::vector<std::uint32_t> next(groups.begin.begin(), groups.begin.end() - 1);
  for (std::uint32_t i = 0; i < owners.size(); ++i) {
    if (owners[i] != kNone) groups.members[next[owners[i]]++] = i;
  }
  return groups;
}

// How the returns of one landmark fit together.
struct Fit {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< sum of theirs
  double misfit = 0.0;  ///< sum of their squared Mahalanobis distances to the mean
  std::uint32_t support = 0;
};

class Fusion {
 public:
  Fusion(std::span<const MapReturn> returns, std::span<const std::uint32_t> pass_of_scan,
         bool has_elevation, const FusionOptions& options)
      : returns_(returns),
        pass_of_scan_(pass_of_scan),
        has_elevation_(has_elevation),
        options_(options) {}

  std::vector<Landmark> Run() {
    FoundCenters();
    for (int round = 0; round < kRounds; ++round) {
      MoveCenters(GroupByOwner(JoinReturns(), centers_m_.size()));
      UniteCenters();
    }
    const Groups groups = GroupByOwner(JoinReturns(), centers_m_.size());
    MoveCenters(groups);
    FitHeights(groups);
    return DescribeLandmarks(groups);
  }

 private:
  // Where the scatterer of return `i` may lie about it.
  Eigen::Matrix3d ScattererCovariance(std::uint32_t i) const {
    const double size_m = options_.cell_m / 4.0;
    return MeasurementCovariance(returns_[i]) + size_m * size_m * Eigen::Matrix3d::Identity();
  }

  // Its inverse; without elevation that of x and y, and z weighs the same in every return.
  Eigen::Matrix3d Information(const Eigen::Matrix3d& covariance) const {
    if (has_elevation_) return covariance.inverse();
    Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
    information.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>().inverse();
    return information;
  }

  double SquaredDistance(Eigen::Vector3d offset_m, const Eigen::Matrix3d& information) const {
    if (!has_elevation_) offset_m.z() = 0.0;
    return offset_m.dot(information * offset_m);
  }

  // The center that explains return `i` best, or kNone if none does.
  std::uint32_t BestCenter(std::uint32_t i) const {
    const Eigen::Matrix3d covariance = ScattererCovariance(i);
    const Eigen::Matrix3d information = Information(covariance);
    const double gate = has_elevation_ ? kSpatialGate : kPlanarGate;
    const Eigen::Vector2d box_m = (gate * covariance.diagonal().head<2>()).cwiseSqrt();
    std::pair<double, std::uint32_t> best(gate, kNone);
    grid_.ForEachNear(returns_[i].position_m.head<2>(), box_m, [&](std::uint32_t center) {
      const Eigen::Vector3d offset_m = centers_m_[center] - returns_[i].position_m;
      best = std::min(best, {SquaredDistance(offset_m, information), center});
    });
    return best.second;
  }

  void AddCenter(const Eigen::Vector3d& center_m) {
    centers_m_.push_back(center_m);
    grid_.Insert(center_m.head<2>());
  }

  void FoundCenters() {
    std::vector<float> spread(returns_.size());
    for (std::uint32_t i = 0; i < returns_.size(); ++i) {
      spread[i] = static_cast<float>(ScattererCovariance(i).topLeftCorner<2, 2>().determinant());
    }
    std::vector<std::uint32_t> order(returns_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return spread[i]; });
    for (const std::uint32_t i : order) {
      if (BestCenter(i) == kNone) AddCenter(returns_[i].position_m);
    }
  }

  std::vector<std::uint32_t> JoinReturns() const {
    std::vector<std::uint32_t> owners(returns_.size());
    for (std::uint32_t i = 0; i < returns_.size(); ++i) owners[i] = BestCenter(i);
    return owners;
  }

  void MoveCenters(const Groups& groups) {
    fits_.resize(centers_m_.size());
    for (std::size_t c = 0; c < centers_m_.size(); ++c) {
      const std::span<const std::uint32_t> members = groups.Of(c);
      fits_[c] = {.support = static_cast<std::uint32_t>(members.size())};
      if (members.empty()) continue;
      Eigen::Vector3d pull = Eigen::Vector3d::Zero();
      for (const std::uint32_t i : members) {
        const Eigen::Matrix3d information = Information(ScattererCovariance(i));
        const Eigen::Vector3d offset_m = returns_[i].position_m - centers_m_[c];
        fits_[c].information += information;
        fits_[c].misfit += SquaredDistance(offset_m, information);
        pull += information * offset_m;
      }
      const Eigen::Vector3d step_m = fits_[c].information.inverse() * pull;
      fits_[c].misfit -= SquaredDistance(step_m, fits_[c].information);
      centers_m_[c] += step_m;
    }
  }

  // What one landmark in place of two would be.
  struct Union {
    Eigen::Vector3d center_m;
    Fit fit;
  };
  Union Unite(const Eigen::Vector3d& a_m, const Fit& a, const Eigen::Vector3d& b_m,
              const Fit& b) const {
    const Eigen::Matrix3d information = a.information + b.information;
    const Eigen::Vector3d offset_m = b_m - a_m;
    const Eigen::Vector3d step_m = information.inverse() * b.information * offset_m;
    return {.center_m = a_m + step_m,
            .fit = {.information = information,
                    .misfit = a.misfit + b.misfit + SquaredDistance(step_m, a.information) +
                              SquaredDistance(offset_m - step_m, b.information),
                    .support = a.support + b.support}};
  }

  // Noise alone puts returns this far from their scatterer: one landmark explains them all.
  bool IsOneScatterer(const Fit& fit) const {
    const double freedom = has_elevation_ ? 3.0 : 2.0;
    return fit.misfit <= freedom * fit.support;
  }

  // From the best supported down, each joins a kept neighbour where the two are one scatterer as
  // far as the measurements can tell.
  void UniteCenters() {
    std::vector<std::uint32_t> order(centers_m_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](std::uint32_t c) { return fits_[c].support; });
    const std::vector<Eigen::Vector3d> candidates_m = std::exchange(centers_m_, {});
    const std::vector<Fit> candidates = std::exchange(fits_, {});
    grid_ = PointGrid(kGridCell_m);
    for (const std::uint32_t c : order) {
      if (candidates[c].support == 0) break;
      const std::uint32_t kept = BestUnion(candidates_m[c], candidates[c]);
      if (kept == kNone) {
        AddCenter(candidates_m[c]);
        fits_.push_back(candidates[c]);
      } else {
        const Union united = Unite(centers_m_[kept], fits_[kept], candidates_m[c], candidates[c]);
        centers_m_[kept] = united.center_m;
        fits_[kept] = united.fit;
      }
    }
    grid_ = PointGrid(kGridCell_m);
    for (const Eigen::Vector3d& center_m : centers_m_) grid_.Insert(center_m.head<2>());
  }

  std::uint32_t BestUnion(const Eigen::Vector3d& center_m, const Fit& fit) const {
    // No further than its own returns typically reach.
    const Eigen::Vector2d box_m =
        (kPlanarGate * fit.support * fit.information.inverse().diagonal().head<2>()).cwiseSqrt();
    std::pair<double, std::uint32_t> best(std::numeric_limits<double>::infinity(), kNone);
    grid_.ForEachNear(center_m.head<2>(), box_m, [&](std::uint32_t kept) {
      const Fit united = Unite(centers_m_[kept], fits_[kept], center_m, fit).fit;
      if (!IsOneScatterer(united)) return;
      best = std::min(best, {united.misfit - fits_[kept].misfit, kept});
    });
    return best.second;
  }

  // Squared heights of the landmarks, and their positions corrected for them.
  void FitHeights(const Groups& groups) {
    constexpr double kMinReturns = 3.0;
    height_squares_m2_.assign(centers_m_.size(), 0.0);
    if (has_elevation_ || options_.height_square_sigma_m2 <= 0.0) return;
    for (std::size_t c = 0; c < centers_m_.size(); ++c) {
      const auto count = static_cast<double>(fits_[c].support);
      if (count < kMinReturns) continue;
      HeightFit fit;
      for (const std::uint32_t i : groups.Of(c)) {
        fit.Add(Information(ScattererCovariance(i)).topLeftCorner<2, 2>(), Slant(i),
                (returns_[i].position_m - centers_m_[c]).head<2>());
      }
      // Returns that lie further apart than their noise says determine the height less well.
      const double misfit = std::max(1.0, fits_[c].misfit / (2.0 * count - 2.0));
      const HeightFit::Solution solution =
          fit.Solve(misfit / std::pow(options_.height_square_sigma_m2, 2));
      height_squares_m2_[c] = solution.height_square_m2;
      centers_m_[c].head<2>() += solution.shift_m;
    }
  }

  Eigen::Vector2d Slant(std::uint32_t i) const {
    return {returns_[i].slant_per_m[0], returns_[i].slant_per_m[1]};
  }

  std::vector<Landmark> DescribeLandmarks(const Groups& groups) const {
    const auto min_scan_count = static_cast<std::uint32_t>(options_.min_scan_count);
    std::vector<Landmark> landmarks;
    for (std::size_t c = 0; c < centers_m_.size(); ++c) {
      const Landmark landmark = Describe(c, groups.Of(c));
      if (landmark.scan_count >= min_scan_count) landmarks.push_back(landmark);
    }
    return landmarks;
  }

  Landmark Describe(std::size_t c, std::span<const std::uint32_t> members) const {
    Landmark landmark{.position_m = centers_m_[c],
                      .covariance_m2 = Covariance(c, members),
                      .rcs_dbsm = 0.0F,
                      .scan_count = 0,
                      .pass_count = 0,
                      .height_m = std::sqrt(height_squares_m2_[c])};
    std::uint32_t last_scan = kNone;
    std::uint32_t last_pass = kNone;
    for (const std::uint32_t i : members) {
      const std::uint32_t scan = returns_[i].scan;
      landmark.rcs_dbsm += returns_[i].rcs_dbsm / static_cast<float>(members.size());
      if (scan != last_scan) ++landmark.scan_count;
      if (pass_of_scan_[scan] != last_pass) ++landmark.pass_count;
      last_scan = scan;
      last_pass = pass_of_scan_[scan];
    }
    return landmark;
  }

  // Spread of the returns beyond their noise + uncertainty of the mean + floor. Each return weighs
  // by the inverse square of its variance, as is best for estimating a variance from such returns.
  Eigen::Matrix3d Covariance(std::size_t c, std::span<const std::uint32_t> members) const {
    Eigen::Matrix3d total = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
    double weights = 0.0;
    for (const std::uint32_t i : members) {
      const Eigen::Matrix3d covariance = ScattererCovariance(i);
      Eigen::Vector3d offset_m = returns_[i].position_m - centers_m_[c];
      offset_m.head<2>() -= height_squares_m2_[c] * Slant(i);
      const double weight = 1.0 / std::pow(covariance.topLeftCorner<2, 2>().trace(), 2);
      total += Information(covariance);
      spread += weight * offset_m * offset_m.transpose();
      noise += weight * MeasurementCovariance(returns_[i]);
      weights += weight;
    }
    const auto count = static_cast<double>(members.size());
    // The mean was fitted to the same returns, which makes them look nearer to it than they are.
    spread *= count > 1.0 ? count / (count - 1.0) / weights : 0.0;
    noise /= weights;
    const Eigen::Matrix3d floor = kFloor_m2 * Eigen::Matrix3d::Identity();
    if (has_elevation_) {
      return ClipToPsd<3>(spread - noise) + total.inverse() + floor;
    }
    // Without elevation, what is not known of a return's z is not known of the landmark's.
    Eigen::Matrix3d covariance = floor;
    covariance.topLeftCorner<2, 2>() += ClipToPsd<2>((spread - noise).topLeftCorner<2, 2>()) +
                                        total.topLeftCorner<2, 2>().inverse();
    covariance(2, 2) += noise(2, 2);
    return covariance;
  }

  std::span<const MapReturn> returns_;
  std::span<const std::uint32_t> pass_of_scan_;
  bool has_elevation_;
  FusionOptions options_;
  std::vector<Eigen::Vector3d> centers_m_;
  std::vector<double> height_squares_m2_;
  std::vector<Fit> fits_;        ///< of the returns that joined each center last
  PointGrid grid_{kGridCell_m};  ///< of centers_m_ as they were when last founded or united
};

}  // namespace

std::span<const OptionField<FusionOptions>> FieldsOf(const FusionOptions& /*options*/) {
  using O = FusionOptions;
  static constexpr OptionField<O> kFields[] = {
      {"cell_m", &O::cell_m, 0.05, 10},
      {"min_scan_count", &O::min_scan_count, 1, 65535},
      {"height_square_sigma_m2", &O::height_square_sigma_m2, 0, 1000,
       "landmarks are as high as the radar"},
  };
  return kFields;
}

absl::Status Validate(const FusionOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::vector<Landmark> FuseLandmarks(std::span<const MapReturn> returns,
                                    std::span<const std::uint32_t> pass_of_scan, bool has_elevation,
                                    const FusionOptions& options) {
  return Fusion(returns, pass_of_scan, has_elevation, options).Run();
}

}  // namespace dcloc
