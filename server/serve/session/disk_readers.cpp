#include "server/serve/session/disk_readers.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <list>
#include <map>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

#include "common/error.h"
#include "common/start_thread.h"

namespace lode::serve {

namespace {

constexpr const char* kReading = "to read stores";

}  // namespace

struct DiskReaders::State : std::enable_shared_from_this<State> {
  struct Read {
    std::shared_ptr<const BlobReader> blobs;
    BlobRange range;
    Done done;  ///< empty once the read has ended for its caller
    ReadResult result = ReadResult::kUnreadable;
    std::vector<std::byte> bytes;
    TimePoint begin{};
    bool is_blocked = false, is_late = false;
  };
  using Reads = std::list<Read>;
  /// The reads of one store. Reads move between lists without an allocation.
  struct Store {
    Reads waiting, running;
    size_t late = 0;  ///< number of running reads that are late
  };
  using Stores = std::map<const BlobReader*, Store>;

  void startThread();
  void work();
  Stores::iterator next() noexcept;
  size_t readsPerStore() const noexcept {
    return blocked_threads > options.many_blocked ? 1 : options.reads_per_store;
  }
  bool canBegin(const Store& store) const noexcept {
    return !store.waiting.empty() && store.running.size() < readsPerStore();
  }
  /// Returns true if further reads of the store would only wait behind late ones.
  bool isStalled(const Store& store) const noexcept {
    return store.late == store.running.size() && store.late >= readsPerStore();
  }
  void runTask(std::unique_lock<std::mutex>& lock);
  void runRead(Stores::iterator store, std::unique_lock<std::mutex>& lock);
  void collectLate(TimePoint now, std::vector<std::shared_ptr<const BlobReader>>& stalled);
  void countBlocked(TimePoint now) noexcept;
  void replaceThreads();
  void deliver(Reads reads) noexcept;

  DiskReaderOptions options;
  std::mutex mutex;  ///< guards the members below
  std::condition_variable changed;
  Stores stores;                     ///< stores with reads
  Reads undelivered;                 ///< ended reads for which the next tick() calls `done`
  const BlobReader* last = nullptr;  ///< store of the last read that began; next() searches after this store
  std::deque<std::function<void()>> tasks;
  size_t threads = 0;          ///< threads that are not blocked
  size_t blocked_threads = 0;  ///< threads whose read takes longer than replace_after
  bool stopping = false;
};

/// Starts a thread, which the caller has counted.
void DiskReaders::State::startThread() {
  lode::startThread(kReading, [self = shared_from_this()] { self->work(); }).detach();
}

void DiskReaders::State::work() {
  std::unique_lock lock(mutex);
  // If there are more than options.threads threads, another thread has replaced this thread.
  while (threads <= options.threads && !stopping) {
    if (const auto store = next(); store != stores.end())
      runRead(store, lock);
    else if (!tasks.empty())
      runTask(lock);
    else
      changed.wait(lock);
  }
  --threads;
  changed.notify_all();
}

/// Returns the next store that can begin a read, or end() if no store can. The search begins after `last` and
/// wraps around at the end.
DiskReaders::State::Stores::iterator DiskReaders::State::next() noexcept {
  const auto ready = [this](const auto& entry) { return canBegin(entry.second); };
  const auto after = stores.upper_bound(last);
  if (const auto found = std::find_if(after, stores.end(), ready); found != stores.end()) return found;
  const auto found = std::find_if(stores.begin(), after, ready);
  return found == after ? stores.end() : found;
}

void DiskReaders::State::runTask(std::unique_lock<std::mutex>& lock) {
  const std::function<void()> task = std::move(tasks.front());
  tasks.pop_front();
  lock.unlock();
  task();
  lock.lock();
}

void DiskReaders::State::runRead(Stores::iterator entry, std::unique_lock<std::mutex>& lock) {
  Store& store = entry->second;  // remains while the store has a read
  last = entry->first;
  store.running.splice(store.running.end(), store.waiting, store.waiting.begin());
  const auto read = std::prev(store.running.end());
  read->begin = options.clock();
  lock.unlock();
  read->result = read->blobs->readCold(read->range, read->bytes);
  if (read->result != ReadResult::kDone) read->bytes.clear();
  lock.lock();
  Reads ended;
  ended.splice(ended.end(), store.running, read);
  if (read->is_late) --store.late;
  if (read->is_blocked) {
    --blocked_threads;
    ++threads;
  }
  if (canBegin(store)) changed.notify_one();
  if (store.running.empty() && store.waiting.empty()) stores.erase(entry);
  lock.unlock();
  deliver(std::move(ended));  // may release the last reference to the store, which closes the store
  lock.lock();
}

/// Moves to `undelivered` the reads that have just become late, and the waiting reads of stores whose storage
/// hangs. Adds to `stalled` the readers of the reads that have just become late.
void DiskReaders::State::collectLate(TimePoint now, std::vector<std::shared_ptr<const BlobReader>>& stalled) {
  for (auto& [key, store] : stores) {
    for (Read& read : store.running) {
      if (read.is_late || now - read.begin < options.deadline) continue;
      stalled.push_back(read.blobs);
      undelivered.emplace_back().done.swap(read.done);
      read.is_late = true;
      ++store.late;
    }
    if (isStalled(store)) undelivered.splice(undelivered.end(), store.waiting);
  }
}

void DiskReaders::State::countBlocked(TimePoint now) noexcept {
  for (auto& [key, store] : stores)
    for (Read& read : store.running) {
      if (read.is_blocked || now - read.begin < options.replace_after) continue;
      read.is_blocked = true;
      --threads;
      ++blocked_threads;
    }
}

/// Starts threads in place of blocked ones. If the system refuses one, tick() tries again.
void DiskReaders::State::replaceThreads() {
  while (!stopping && threads < options.threads && threads + blocked_threads < options.max_threads) try {
      ++threads;
      startThread();
    } catch (const Error&) {
      --threads;
      return;
    }
}

/// Calls `done` of each read once. If memory runs out, tick() calls it again for the rest.
void DiskReaders::State::deliver(Reads reads) noexcept {
  while (!reads.empty()) try {
      Read& read = reads.front();
      if (read.done) read.done(read.result, read.bytes);
      reads.pop_front();
    } catch (const std::bad_alloc&) {
      const std::lock_guard lock(mutex);
      undelivered.splice(undelivered.end(), reads);
    }
}

DiskReaders::DiskReaders(DiskReaderOptions options) : state_(std::make_shared<State>()) {
  state_->options = std::move(options);
  try {
    const std::lock_guard lock(state_->mutex);
    while (state_->threads < state_->options.threads) {
      state_->startThread();
      ++state_->threads;
    }
  } catch (const Error&) {
    join();
    throw;
  }
}

DiskReaders::~DiskReaders() { join(); }

void DiskReaders::read(std::shared_ptr<const BlobReader> blobs, const BlobRange& range, Done done) {
  State::Reads one(1);
  State::Read& read = one.front();
  read.blobs = std::move(blobs);
  read.range = range;
  read.done = std::move(done);
  read.bytes.resize(range.bytes);
  const BlobReader* const key = read.blobs.get();
  {
    const std::lock_guard lock(state_->mutex);
    State::Store& store = state_->stores[key];
    if (!state_->stopping && !state_->isStalled(store)) {
      store.waiting.splice(store.waiting.end(), one);
      state_->changed.notify_one();
    }
  }
  state_->deliver(std::move(one));
}

void DiskReaders::post(std::function<void()> task) {
  const std::lock_guard lock(state_->mutex);
  state_->tasks.push_back(std::move(task));
  state_->changed.notify_one();
}

void DiskReaders::tick() {
  State::Reads ended;
  std::vector<std::shared_ptr<const BlobReader>> stalled;
  {
    const std::lock_guard lock(state_->mutex);
    const TimePoint now = state_->options.clock();
    state_->countBlocked(now);
    state_->collectLate(now, stalled);
    state_->replaceThreads();
    ended.swap(state_->undelivered);
  }
  for (const auto& blobs : stalled) blobs->noteLateRead(state_->options.deadline);
  state_->deliver(std::move(ended));
}

void DiskReaders::join() {
  State::Reads ended;
  {
    std::unique_lock lock(state_->mutex);
    state_->stopping = true;
    state_->tasks.clear();
    for (auto& [key, store] : state_->stores) ended.splice(ended.end(), store.waiting);
    state_->changed.notify_all();
    state_->changed.wait_for(lock, kJoinPatience, [this] { return state_->threads == 0; });
    for (auto& [key, store] : state_->stores)
      for (State::Read& read : store.running) ended.emplace_back().done.swap(read.done);
    ended.splice(ended.end(), state_->undelivered);
  }
  state_->deliver(std::move(ended));
}

}  // namespace lode::serve
