"""The paper's part-whole actors, messages and quaternions (§3): its subject."""
