"""The aggregate cover of what is not displayed one by one."""
