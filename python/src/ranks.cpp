// Ranks that Python communicates for.
#include "ranks.h"

#include <chrono>

namespace {

// Every call takes the interpreter's lock: a pass runs without it.
class PythonRanks final : public cmpg::Communicator {
  public:
    explicit PythonRanks(nb::object ranks)
        : ranks_(std::move(ranks)), rank_(nb::cast<int>(ranks_.attr("rank"))), size_(nb::cast<int>(ranks_.attr("size"))),
          localRank_(nb::cast<int>(ranks_.attr("local_rank"))), localSize_(nb::cast<int>(ranks_.attr("local_size"))) {}
    ~PythonRanks() override {
        if (!nb::is_alive()) { // the interpreter has ended
            ranks_.release();
            return;
        }
        const nb::gil_scoped_acquire gil;
        ranks_.reset();
    }
    PythonRanks(const PythonRanks&) = delete;

    int rank() const override { return rank_; }
    int size() const override { return size_; }
    int localRank() const override { return localRank_; }
    int localSize() const override { return localSize_; }
    cmpg::Traffic traffic() const override { return traffic_; }

    void sum(std::span<std::int64_t> values) override {
        const Call call(*this, values.size_bytes());
        ranks_.attr("sum")(view(std::as_writable_bytes(values)));
    }
    void broadcast(std::span<std::byte> bytes, int root) override {
        const Call call(*this, rank_ == root ? bytes.size() : 0);
        ranks_.attr("broadcast")(view(bytes), root);
    }
    void gatherInto(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
        const Call call(*this, own.size());
        const std::span<std::byte> read(const_cast<std::byte*>(own.data()), own.size()); // and not written
        ranks_.attr("gather")(view(read), std::vector<std::size_t>(sizes.begin(), sizes.end()), view(all));
    }
    void passFailed(const std::string& why) noexcept override {
        const nb::gil_scoped_acquire gil;
        const nb::error_scope raised; // by what ended the pass, perhaps
        try {
            ranks_.attr("fail")(nb::steal(PyUnicode_DecodeUTF8(why.data(), Py_ssize_t(why.size()), "replace"))); // names of files need not be UTF-8
        } catch (const std::exception&) { // nothing more can be done
        }
    }

  private:
    struct Call {
        Call(PythonRanks& r, std::size_t bytes) : ranks(r) {
            ++ranks.traffic_.calls;
            ranks.traffic_.bytes += bytes;
        }
        ~Call() { ranks.traffic_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); }
        PythonRanks& ranks;
        std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
        nb::gil_scoped_acquire gil;
    };
    static nb::object view(std::span<std::byte> bytes) {
        static char none[1];
        char* const begin = bytes.empty() ? none : reinterpret_cast<char*>(bytes.data());
        return nb::steal(PyMemoryView_FromMemory(begin, Py_ssize_t(bytes.size()), PyBUF_WRITE));
    }

    nb::object ranks_;
    int rank_, size_, localRank_, localSize_;
    cmpg::Traffic traffic_;
};

} // namespace

std::shared_ptr<cmpg::Communicator> communicatorOf(nb::object ranks) {
    return ranks.is_none() ? nullptr : std::make_shared<PythonRanks>(std::move(ranks));
}
