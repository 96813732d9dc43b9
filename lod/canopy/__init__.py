"""Cover of plants that are not displayed one by one."""
