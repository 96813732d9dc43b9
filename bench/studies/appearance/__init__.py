"""Do leaf appearances look like what they hide, of kinds that nothing was fitted to?"""
