"""Is the same question answered alike, however it is asked?"""
