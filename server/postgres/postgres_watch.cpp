#include "server/postgres/postgres_watch.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <string>
#include <utility>

#include "server/base/within_memory.h"
#include "server/postgres/postgres_error.h"
#include "server/postgres/postgres_migrations.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// The trigger function is for tables of others: as a deferred trigger it runs when the change is
/// committed, so the row is locked for no longer than that.
constexpr const char* kSteps[] = {R"(
CREATE TABLE dcloc.change (topic text PRIMARY KEY, number bigint NOT NULL);
INSERT INTO dcloc.change VALUES ('catalogue', 1), ('identities', 1);
CREATE FUNCTION dcloc.note_change() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
  UPDATE dcloc.change SET number = number + 1 WHERE topic = TG_ARGV[0];
  PERFORM pg_notify('dcloc_change', '');
  RETURN NULL;
END $$;
)"};

constexpr PostgresMigrations kMigrations{.part = "change", .steps = kSteps};

ChangeTopic TopicOf(const std::string& name) {
  return name == "identities" ? ChangeTopic::kIdentities : ChangeTopic::kCatalogue;
}

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresWatch>> PostgresWatch::Open(PostgresPool& pool) {
  absl::Status status = pool.WithConnection(
      [](PostgresConnection& connection) { return Migrate(connection, kMigrations); });
  if (!status.ok()) return status;
  std::unique_ptr<PostgresWatch> watch(new PostgresWatch(pool));
  if (watch->wake_.get() < 0) return absl::ResourceExhaustedError("no file is left for an event");
  status = watch->Look(/*is_new=*/true);
  if (!status.ok()) return status;
  watch->thread_ = std::jthread([watch = watch.get()](const std::stop_token& stop) {
    const std::stop_callback wake(stop, [watch] { watch->Wake(); });
    watch->Run(stop);
  });
  return watch;
}

PostgresWatch::PostgresWatch(PostgresPool& pool)
    : pool_(pool), wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

PostgresWatch::~PostgresWatch() = default;

ChangeState PostgresWatch::state(ChangeTopic topic) const {
  const std::lock_guard lock(mutex_);
  ChangeState state = states_[static_cast<std::size_t>(topic)];
  state.fresh = std::chrono::steady_clock::now() - state.confirm_time < kMaxChangeDelay;
  return state;
}

std::shared_ptr<void> PostgresWatch::Add(Task task) {
  const std::lock_guard lock(tasks_mutex_);
  tasks_.push_front(std::move(task));
  return {nullptr, [this, entry = tasks_.begin()](std::nullptr_t) {
            const std::lock_guard erase_lock(tasks_mutex_);
            tasks_.erase(entry);
          }};
}

void PostgresWatch::Wake() { eventfd_write(wake_.get(), 1); }

void PostgresWatch::Run(const std::stop_token& stop) {
  while (true) {
    Pause(kInterval);
    if (stop.stop_requested()) return;
    const absl::Status status =
        WithinMemory([this] { return Look(/*is_new=*/connection_ == nullptr); });
    if (status.ok()) {
      pool_.NoteBack();
    } else {
      connection_.reset();
      // Busy, or its disk is full: then it is there, and the next look may tell more.
      if (IsAway(status)) pool_.NoteAway(status);
    }
  }
}

absl::Status PostgresWatch::Look(bool is_new) {
  absl::Status status = is_new ? Connect() : connection_->TakeNotifications().status();
  if (status.ok()) status = ReadNumbers();
  const std::lock_guard lock(tasks_mutex_);
  for (auto task = tasks_.begin(); status.ok() && task != tasks_.end(); ++task) {
    status = (*task)(*connection_, is_new);
  }
  return status;
}

absl::Status PostgresWatch::Connect() {
  absl::StatusOr<std::unique_ptr<PostgresConnection>> connection =
      PostgresConnection::Open(pool_.options());
  if (!connection.ok()) return connection.status();
  connection_ = *std::move(connection);
  return connection_->Query("LISTEN dcloc_change").status();
}

absl::Status PostgresWatch::ReadNumbers() {
  const auto now = std::chrono::steady_clock::now();  // before it is asked
  absl::StatusOr<PostgresRows> rows = connection_->Query("SELECT topic, number FROM dcloc.change");
  if (!rows.ok()) return rows.status();
  const std::lock_guard lock(mutex_);
  while (rows->Next()) {
    ChangeState& state = states_[static_cast<std::size_t>(TopicOf(rows->NextText()))];
    state.number = rows->NextInteger();
    state.confirm_time = now;
  }
  return absl::OkStatus();
}

void PostgresWatch::Pause(std::chrono::milliseconds duration) {
  pollfd ready[2] = {{.fd = wake_.get(), .events = POLLIN, .revents = 0},
                     {.fd = connection_ == nullptr ? -1 : connection_->descriptor(),
                      .events = POLLIN,
                      .revents = 0}};
  poll(ready, 2, static_cast<int>(duration.count()));
  eventfd_t count = 0;
  eventfd_read(wake_.get(), &count);
}

}  // namespace dcloc::server
