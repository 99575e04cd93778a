//! How much memory a scene may take, so that absurd sizes are refused in words before they are tried.

use std::fs::read_to_string;

/// Where the operating system does not tell, bytes.
const UNKNOWN: u64 = 1 << 40;
/// Bytes that an atom takes at least while it is simulated: state, engine arrays and their copies.
pub const BYTES_PER_ATOM: u64 = 400;

/// Bytes this process can still have: what the machine has free, or less where its control group (a container) allows less.
pub fn available() -> u64 {
    let free = read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
    });
    let number = |path: &str| read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let group = number("/sys/fs/cgroup/memory.max")
        .zip(number("/sys/fs/cgroup/memory.current"))
        .map(|(limit, used)| limit.saturating_sub(used));
    free.unwrap_or(UNKNOWN).min(group.unwrap_or(UNKNOWN))
}

#[cfg(test)]
mod tests {
    #[test]
    fn there_is_memory_for_a_few_atoms() {
        assert!(super::available() > 1000 * super::BYTES_PER_ATOM);
    }
}
